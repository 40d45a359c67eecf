// How the element looks. It fills the box that the page gives it.
export const style = `
:host { display: block; position: relative; aspect-ratio: 4 / 3; background: #000; color: #fff; overflow: hidden;
  font: 14px/1.4 system-ui, sans-serif; }
:host([hidden]) { display: none; }
.stage { position: absolute; inset: 0; touch-action: none; cursor: grab; }
.stage:active { cursor: grabbing; }
.stage canvas, .poster { position: absolute; inset: 0; width: 100%; height: 100%; }
.poster { object-fit: contain; }
:focus-visible { outline: 3px solid #6cf; outline-offset: -3px; }
[hidden] { display: none !important; }
.state { position: absolute; inset: auto 0 50% 0; margin: auto; width: max-content; max-width: 90%; display: flex; gap: 10px;
  align-items: center; padding: 8px 14px; border-radius: 8px; background: #000b; pointer-events: none; }
.spinner { width: 18px; height: 18px; border: 3px solid #fff4; border-top-color: #fff; border-radius: 50%;
  animation: turn 1s linear infinite; }
@keyframes turn { to { transform: rotate(1turn); } }
.fault { position: absolute; inset: 0; display: grid; place-content: center; padding: 24px; text-align: center;
  overflow-wrap: anywhere; background: #1a1a1a; }
.fault.beside { inset: 0 0 auto 0; padding: 8px 14px; background: #000b; pointer-events: none; }
.empty { position: absolute; inset: 0; margin: auto; width: max-content; padding: 0 20px; border: 1px dashed #888; }
.bar { position: absolute; inset: auto 0 0 0; display: flex; align-items: center; gap: 4px; padding: 24px 8px 6px;
  background: linear-gradient(#0000, #000c); transition: opacity .2s; }
:host(.playing:not(:hover):not(:focus-within)) .bar { opacity: 0; }
button { display: grid; place-content: center; min-width: 40px; height: 40px; border: 0; border-radius: 8px; background: none;
  color: inherit; font: inherit; cursor: pointer; }
button:hover { background: #fff3; }
svg { width: 24px; height: 24px; fill: currentColor; }
input[type=range] { flex: 1; min-width: 60px; height: 40px; accent-color: #6cf; cursor: pointer; }
.time { font-variant-numeric: tabular-nums; padding: 0 6px; white-space: nowrap; }
.menu { position: absolute; right: 8px; bottom: 60px; max-height: calc(100% - 80px); overflow: auto; min-width: 190px;
  padding: 10px 14px; border-radius: 10px; background: #222e; }
fieldset { border: 0; margin: 0 0 8px; padding: 0; }
legend { padding: 0; color: #bbb; font-size: 12px; }
label { display: flex; align-items: center; gap: 8px; min-height: 28px; }
select { margin-left: auto; color: inherit; background: #000; border: 1px solid #888; border-radius: 4px; font: inherit; }
.menu button { width: 100%; height: 32px; place-content: center start; }
:host(.dropping)::after { content: ""; position: absolute; inset: 12px; border: 4px dashed #6cf; pointer-events: none; }
@media (prefers-reduced-motion: reduce) { .spinner { animation: none; } .bar { transition: none; } }
`;
