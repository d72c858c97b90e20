/** Width of the panel; units of the drawing. */
export const WIDTH = 320;

/**
 * Width and height of a joint: the fewer there are, the larger they are drawn.
 *
 * @param {number} count
 */
export function cellOf(count) {
  const width = { 1: 96, 2: 96, 3: 96, 4: 76 }[count] ?? 62;
  return { width, height: Math.round(width * 1.62) };
}

const GAP = 4; // units that are left free around a joint
const STEP = 4; // units between the heights that are tried
const SPREAD = 140; // units between the lowest and the highest place of a panel
const EDGE = 1 / 8; // of the panel's width; joints further out are drawn at the edge

/**
 * Where joints are drawn. Each stays where it is from left to right, and as near as it can to its height: joints that
 * would lie on each other are drawn one above the other. The same on every screen.
 *
 * @param {readonly (readonly [number, number] | null)[]} places From the left and from below, [0, 1]; null for a joint
 *   of which no place is known.
 * @returns {{spots: {x: number, y: number}[], cell: {width: number, height: number}, height: number}} Middles of the
 *   joints from the upper left corner, the room of each, and the height of the panel.
 */
export function layout(places) {
  const known = places.map((place, i) => place ?? [(i + 0.5) / places.length, 0.5]);
  const left = Math.min(EDGE, ...known.map(([x]) => x));
  const right = Math.max(1 - EDGE, ...known.map(([x]) => x));
  const cell = cellOf(places.length);
  const middle = WIDTH - cell.width;
  const spots = known.map(([x, y]) => ({
    x: cell.width / 2 + (middle * (x - left)) / (right - left),
    y: (1 - y) * SPREAD,
  }));
  const order = spots.map((_, i) => i).sort((a, b) => spots[a].x - spots[b].x || spots[a].y - spots[b].y);
  const drawn = [];
  for (const i of order) {
    spots[i].y = freeHeight(spots[i], drawn, cell);
    drawn.push(spots[i]);
  }
  const top = Math.min(...spots.map(({ y }) => y)) - cell.height / 2;
  for (const spot of spots) spot.y -= top;
  return { spots, cell, height: Math.max(...spots.map(({ y }) => y)) + cell.height / 2 };
}

/** The nearest height at which a joint lies on no other; below before above. */
function freeHeight({ x, y }, others, cell) {
  const inWay = others.filter((other) => Math.abs(other.x - x) < cell.width);
  const free = (height) => inWay.every((other) => Math.abs(other.y - height) >= cell.height + GAP);
  for (let off = 0; ; off += STEP) {
    if (free(y + off)) return y + off;
    if (free(y - off)) return y - off;
  }
}
