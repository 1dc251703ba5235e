/** Checked reading of JSON values: what is damaged is named by its place. */

export class DataError extends Error {
  constructor(where: string, what: string) {
    super(`${where}: ${what}`);
    this.name = "DataError";
  }
}

/** A JSON value and the place it has in the data. */
export class Reader {
  constructor(
    readonly value: unknown,
    readonly where: string,
  ) {}

  get isNull(): boolean {
    return this.value === null || this.value === undefined;
  }

  field(name: string): Reader {
    if (typeof this.value !== "object" || this.value === null || Array.isArray(this.value)) {
      throw new DataError(this.where, "is not an object");
    }
    return new Reader((this.value as Record<string, unknown>)[name], `${this.where}.${name}`);
  }

  items(): Reader[] {
    if (!Array.isArray(this.value)) throw new DataError(this.where, "is not a list");
    return this.value.map((each, index) => new Reader(each, `${this.where}[${index}]`));
  }

  text(): string {
    if (typeof this.value !== "string") throw new DataError(this.where, "is not text");
    return this.value;
  }

  number(): number {
    if (typeof this.value !== "number" || !Number.isFinite(this.value)) {
      throw new DataError(this.where, "is not a finite number");
    }
    return this.value;
  }

  numbers(count: number): number[] {
    const values = this.items().map((each) => each.number());
    if (values.length !== count) throw new DataError(this.where, `has ${values.length} numbers, not ${count}`);
    return values;
  }

  index(count: number): number {
    const value = this.number();
    if (!Number.isInteger(value) || value < 0 || value >= count) {
      throw new DataError(this.where, `is ${value}, not a place from 0 to ${count - 1}`);
    }
    return value;
  }

  choice<T extends string>(choices: readonly T[]): T {
    const match = choices.find((each) => each === this.value);
    if (match === undefined) throw new DataError(this.where, `is none of ${choices.join(", ")}`);
    return match;
  }

  version(supported: number): void {
    const version = this.field("version").number();
    if (version !== supported) {
      throw new DataError(this.where, `has version ${version}; this page reads version ${supported}`);
    }
  }

  /** Single-precision numbers, finite; of `count` if that is given. They may have been decoded before. */
  floats(count?: number): Float32Array {
    if (this.value instanceof Float32Array) return finite(this.value, this.where);
    return finite(new Float32Array(this.bytes(4, count)), this.where);
  }

  doubles(count?: number): Float64Array {
    return finite(new Float64Array(this.bytes(8, count)), this.where);
  }

  integers(): Uint32Array {
    return new Uint32Array(this.bytes(4));
  }

  private bytes(width: number, count?: number): ArrayBuffer {
    const buffer = decodeBase64(this.text(), this.where);
    const length = buffer.byteLength / width;
    if (!Number.isInteger(length)) throw new DataError(this.where, "is truncated");
    if (count !== undefined && length !== count) {
      throw new DataError(this.where, `has ${length} numbers, not ${count}`);
    }
    return buffer;
  }
}

function finite<T extends Float32Array | Float64Array>(values: T, where: string): T {
  for (let index = 0; index < values.length; index += 1) {
    if (!Number.isFinite(values[index])) throw new DataError(where, `number ${index} is not finite`);
  }
  return values;
}

function decodeBase64(text: string, where: string): ArrayBuffer {
  let binary: string;
  try {
    binary = atob(text);
  } catch {
    throw new DataError(where, "is not base64");
  }
  const bytes = new Uint8Array(binary.length);
  for (let index = 0; index < binary.length; index += 1) bytes[index] = binary.charCodeAt(index);
  return bytes.buffer;
}
