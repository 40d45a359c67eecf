// Bytes of a file that come in any order.

interface Piece {
  start: number;
  end: number;
  come: Blob;
  fresh: Uint8Array<ArrayBuffer>[]; // behind `come`
}

export class HeldBytes {
  #pieces: Piece[] = []; // sorted; no two touch

  /** How many there are. */
  get bytes(): number {
    return this.#pieces.reduce((sum, { start, end }) => sum + end - start, 0);
  }
  /** How many follow each other from the file's first on. */
  get front(): number {
    const first = this.#pieces[0];
    return first?.start === 0 ? first.end : 0;
  }

  /** What is there already stays as it is. */
  add(start: number, bytes: Uint8Array<ArrayBuffer>): void {
    let at = start;
    const end = start + bytes.length;
    while (at < end) {
      const known = this.#pieces.find((piece) => piece.start <= at && at < piece.end);
      if (known) {
        at = known.end;
        continue;
      }
      const until = Math.min(end, ...this.#pieces.filter((piece) => piece.start > at).map((piece) => piece.start));
      this.#put(at, bytes.subarray(at - start, until - start));
      at = until;
    }
  }

  set(whole: Blob): void {
    this.#pieces = [{ start: 0, end: whole.size, come: whole, fresh: [] }];
  }

  /** The first bytes that are not there, from `from` on: up to the next that are; null: all are there before `size`. */
  missing(from: number, size: number): { from: number; until: number } | null {
    let start = from;
    for (const piece of this.#pieces) {
      if (piece.end <= start) continue;
      if (piece.start > start) return { from: start, until: Math.min(piece.start, size) };
      start = piece.end;
    }
    return start < size ? { from: start, until: size } : null;
  }

  /** All of them, one piece behind the other. */
  blob(): Blob {
    for (const piece of this.#pieces) {
      if (piece.fresh.length > 0) piece.come = new Blob([piece.come, ...piece.fresh]);
      piece.fresh = [];
    }
    if (this.#pieces.length === 1) return this.#pieces[0]!.come;
    return new Blob(this.#pieces.map(({ come }) => come));
  }

  #put(start: number, bytes: Uint8Array<ArrayBuffer>): void {
    const end = start + bytes.length;
    const before = this.#pieces.find((piece) => piece.end === start);
    const after = this.#pieces.find((piece) => piece.start === end);
    const piece = before ?? { start, end, come: new Blob(), fresh: [] };
    piece.fresh.push(bytes);
    piece.end = end;
    if (!before) this.#pieces.push(piece);
    if (after) {
      piece.come = new Blob([piece.come, ...piece.fresh, after.come, ...after.fresh]);
      piece.fresh = [];
      piece.end = after.end;
      this.#pieces.splice(this.#pieces.indexOf(after), 1);
    }
    this.#pieces.sort((a, b) => a.start - b.start);
  }
}
