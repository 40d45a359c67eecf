// What can go wrong, with the codes of MediaError.

export const FaultCode = { aborted: 1, network: 2, decode: 3, notSupported: 4 } as const;
export type FaultCode = (typeof FaultCode)[keyof typeof FaultCode];

export class Fault extends Error {
  constructor(
    readonly code: FaultCode,
    message: string,
  ) {
    super(message);
  }
}

/** KinoraPlayerStatus of player.h: what is no clip, and what is damaged. */
export function faultOfStatus(status: number, sentence: string): Fault {
  return new Fault(status === 3 ? FaultCode.notSupported : FaultCode.decode, sentence);
}

export function asFault(thrown: unknown): Fault {
  if (thrown instanceof Fault) return thrown;
  const sentence = thrown instanceof Error ? thrown.message : String(thrown);
  return new Fault(FaultCode.decode, sentence);
}
