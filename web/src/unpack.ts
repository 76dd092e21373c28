// Reads the series that `mjxwalk/player/packing.py` packed.

import type { Stored } from "./show";

/** Returns the bytes of base64 text that was zipped. */
export async function unzip(text: string): Promise<Uint8Array> {
  const zipped = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([zipped]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Returns each channel's values: sums of differences, whose high bytes lie before the low ones. */
export function unpack(bytes: Uint8Array, stored: Stored): Float32Array[] {
  const { channels, places, step, offset } = stored;
  const low = offset + channels * places;
  return Array.from({ length: channels }, (_, channel) => {
    const values = new Float32Array(places);
    let sum = 0;
    for (let place = 0; place < places; place++) {
      const at = channel * places + place;
      sum += ((bytes[offset + at]! << 24) >> 16) | bytes[low + at]!;
      values[place] = sum * step;
    }
    return values;
  });
}
