// The numbers of <script id="bodies">, which viewer.js draws: those of a run have fields (see data_of in
// shape_viewer.cpp), those of a scene that has not run (scene_page.cpp) the kind of each cell, and dots that mark nodes.
"use strict";

// YlOrRd and RdBu of colorbrewer2.org: told apart by colour-blind eyes; the second from compression to tension.
const magnitudeColours = ["ffffcc", "ffeda0", "fed976", "feb24c", "fd8d3c", "fc4e2a", "e31a1c", "bd0026", "800026"];
const signedColours = ["053061", "2166ac", "4393c3", "92c5de", "d1e5f0", "f7f7f7", "fddbc7", "f4a582", "d6604d",
  "b2182b", "67001f"];

function unpacked(text, Type) {
  return new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

function element(parent, name, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(name), properties));
}

class Box {
  constructor() { this.low = [Infinity, Infinity, Infinity]; this.high = [-Infinity, -Infinity, -Infinity]; }
  include(x) {
    for (let c = 0; c < 3; ++c) {
      this.low[c] = Math.min(this.low[c], x[c]);
      this.high[c] = Math.max(this.high[c], x[c]);
    }
  }
  get empty() { return !(this.low[0] <= this.high[0]); }
  get centre() { return this.low.map((low, c) => 0.5 * (low + this.high[c])); }
  get size() { return Math.max(...this.low.map((low, c) => this.high[c] - low)); }
  distance(x) {
    return Math.hypot(...x.map((value, c) => Math.max(0, this.low[c] - value, value - this.high[c])));
  }
}

// The numbers of the page: places and stresses of each piece at each of the kept times.
class Bodies {
  constructor(data) {
    Object.assign(this, { kinds: null, marks: [], fields: [], shown: -1 }, data);
    this.solid = data.model === "solid";
    this.components = data.model === "bar" ? 1 : this.solid ? 3 : 2;
    for (const piece of this.pieces) {
      piece.cell = unpacked(piece.cell, Int32Array);
      piece.edge = unpacked(piece.edge, Uint8Array);
      piece.place = piece.place.map((text) => unpacked(text, Float32Array));
      if (this.kinds) piece.kind = unpacked(piece.kind, Uint8Array);
      for (const { key } of this.fields) piece[key] = piece[key]?.map((text) => unpacked(text, Float32Array));
    }
    for (const mark of this.marks) mark.place = unpacked(mark.place, Float32Array);
    this.box = new Box();
    this.times.forEach((_, time) => this.eachNode(time, (piece, x) => this.box.include(x)));
    if (this.model === "axisymmetric") this.box.include(this.box.high.map((x, c) => (c === 0 ? -x : x)));
    this.showField(0);
  }
  // Which of the fields gives the colours.
  showField(index) {
    this.field = this.fields[index];
    this.hex = (this.field?.signed ? signedColours : magnitudeColours).map((hex) => "#" + hex);
    this.colours = (this.kinds?.map((kind) => kind.colour) ?? this.hex).map((hex) =>
      [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255));
  }
  // One body alone, or all.
  shows(piece) { return this.shown < 0 || piece.body === this.shown; }
  node(piece, time, i) { return this.point(piece.place[time], i); }
  point(place, i) {
    const n = this.components;
    return [place[n * i], n > 1 ? place[n * i + 1] : 0, n > 2 ? place[n * i + 2] : 0];
  }
  eachNode(time, each) {
    for (const piece of this.pieces) {
      const count = piece.place[time].length / this.components;
      for (let i = 0; i < count; ++i) each(piece, this.node(piece, time, i));
    }
  }
  // Corners of a cell; of a bar those of a strip.
  corners(piece, time, cell) {
    const nodes = piece.cell.subarray(4 * cell, 4 * cell + 4);
    if (nodes[2] >= 0) return Array.from(nodes.filter((i) => i >= 0), (i) => this.node(piece, time, i));
    const half = 0.5 * Math.max(this.bodies[piece.body].strip_m, 0.015 * this.box.size);
    const [a, b] = [this.node(piece, time, nodes[0])[0], this.node(piece, time, nodes[1])[0]];
    return [[a, -half, 0], [b, -half, 0], [b, half, 0], [a, half, 0]];
  }
  colour(piece, time, cell) {
    if (this.kinds) return this.colours[piece.kind[cell]];
    if (!piece.stress) return [0.65, 0.65, 0.65];  // what is rigid
    const size = this.value(piece, time, cell) / this.field.high, share = this.field.signed ? 0.5 + 0.5 * size : size;
    const at = Math.min(1, Math.max(0, share)) * (this.colours.length - 1);
    const below = Math.min(Math.floor(at), this.colours.length - 2);
    return this.colours[below].map((value, c) => value + (at - below) * (this.colours[below + 1][c] - value));
  }
  // Of a body without such a field 0.
  value(piece, time, cell) { return piece[this.field.key]?.[time][cell] ?? 0; }
  // What is said of a cell.
  says(piece, cell, time) {
    const body = this.bodies[piece.body].name;
    if (this.kinds) return `${body}, ${this.kinds[piece.kind[cell]].name}`;
    if (!piece.stress) return body;
    const { name, factor, unit } = this.field;
    return `${body}: ${name} ${(this.value(piece, time, cell) * factor).toPrecision(4)} ${unit}`;
  }
  // Contacts of the scene, or pairs of bodies of one that has not run: {name, centre, size, time}, where they press
  // each other most or, if they do not, at the first time at which they come near each other.
  contacts() {
    const found = new Map(), every = this.bodies.flatMap((_, b) => this.bodies.slice(0, b).map((_, a) => [a, b]));
    for (const [a, b] of this.touching ?? every) {
      const name = [a, b].filter((body) => body >= 0).map((body) => this.bodies[body].name).join(" – ");
      const place = this.pressedPlace(a, b) ?? (a >= 0 && b >= 0 ? this.contactOf(a, b) : null);
      if (place && found.size < 12) found.set(name, { name, ...place });
    }
    return [...found.values()];
  }
  // Nodes of the cells of a body that are pressed at a time, those near a box, and the largest pressure.
  pressed(body, time, near = null) {
    const box = new Box();
    let most = 0;
    for (const piece of this.pieces) {
      if (piece.body !== body || !piece.contact_pressure_pa) continue;
      piece.contact_pressure_pa[time].forEach((pressure, cell) => {
        const corners = pressure > 0 ? this.corners(piece, time, cell) : [];
        if (near && corners.some((x) => near.distance(x) > 0.02 * this.box.size)) return;
        corners.forEach((x) => box.include(x));
        most = Math.max(most, pressure);
      });
    }
    return { box, most };
  }
  pressedPlace(a, b) {
    if (!this.fields.some(({ key }) => key === "contact_pressure_pa")) return null;
    let best = { most: 0 };
    for (const time of this.times.keys()) {
      const whole = this.pressed(a, time).box, other = b >= 0 ? this.pressed(b, time).box : null;
      if (whole.empty || other?.empty) continue;
      const { box, most } = this.pressed(a, time, other);
      if (most > best.most) best = { most, time, centre: box.centre, size: Math.max(box.size, 0.05 * this.box.size) };
    }
    return best.most > 0 ? best : null;
  }
  contactOf(a, b) {
    const near = 0.02 * this.box.size;
    for (const time of [this.first, ...this.times.keys()]) {
      const whole = { [a]: new Box(), [b]: new Box() }, close = { [a]: new Box(), [b]: new Box() };
      this.eachNode(time, (piece, x) => whole[piece.body]?.include(x));
      this.eachNode(time, (piece, x) => {
        const other = whole[piece.body === a ? b : a];
        if (whole[piece.body] && !other.empty && other.distance(x) <= near) close[piece.body].include(x);
      });
      if (close[a].empty || close[b].empty) continue;
      const box = close[a].size < close[b].size ? close[a] : close[b];
      return { centre: box.centre, size: Math.max(box.size, 0.05 * this.box.size), time };
    }
    return null;
  }
}
