// Draws the bodies of viewer_bodies.js, before it in the page, with three.js.
"use strict";

// Triangles and lines of all bodies at one time, in arrays that keep their size.
class Shape {
  constructor(bodies) {
    this.bodies = bodies;
    this.mirrors = bodies.model === "axisymmetric" ? [1, -1] : [1];
    this.owners = [];  // of each triangle: [piece, cell]
    const lines = [0, 0, 0];
    for (const piece of bodies.pieces) {
      for (let cell = 0; cell < piece.cell.length / 4; ++cell) {
        const triangle = piece.cell[4 * cell + 2] >= 0 && piece.cell[4 * cell + 3] < 0;
        for (let i = 0; i < (triangle ? 1 : 2) * this.mirrors.length; ++i) this.owners.push([piece, cell]);
      }
      for (const kind of piece.edge) lines[kind] += this.mirrors.length;
    }
    const faces = { position: 9 * this.owners.length, color: 9 * this.owners.length };
    this.faces = Shape.geometry(faces);
    [this.inner, this.outline] = [1, 2].map((kind) => Shape.geometry({ position: 6 * lines[kind], color: 6 * lines[kind] }));
  }
  static geometry(sizes) {
    const geometry = new three.BufferGeometry();
    for (const [name, size] of Object.entries(sizes))
      geometry.setAttribute(name, new three.BufferAttribute(new Float32Array(size), 3));
    return geometry;
  }
  show(time) {
    const face = { at: 0, ...this.arrays(this.faces) }, inner = { at: 0, ...this.arrays(this.inner) };
    const outline = { at: 0, ...this.arrays(this.outline) };
    let length = 0;  // of the inner edges
    const put = (into, x, mirror, colour) => {
      into.position.set([mirror * x[0], x[1], x[2]], into.at);
      into.color.set(colour, into.at);
      into.at += 3;
    };
    for (const piece of this.bodies.pieces) {
      for (let cell = 0; cell < piece.cell.length / 4; ++cell) {
        let corners = this.bodies.corners(piece, time, cell);
        if (!this.bodies.shows(piece)) corners = corners.map(() => corners[0]);  // without an area nothing is drawn
        const colour = this.bodies.colour(piece, time, cell);
        for (const mirror of this.mirrors) {
          for (let i = 2; i < corners.length; ++i)
            for (const k of [0, i - 1, i]) put(face, corners[k], mirror, colour);
          for (let i = 0; i < corners.length; ++i) {
            const kind = piece.edge[4 * cell + i];
            if (kind === 0) continue;
            const dark = kind === 2 ? [0.1, 0.1, 0.1] : colour.map((value) => 0.6 * value);
            for (const k of [i, (i + 1) % corners.length]) put(kind === 2 ? outline : inner, corners[k], mirror, dark);
            if (kind === 1) length += Math.hypot(...corners[i].map((x, c) => x - corners[(i + 1) % corners.length][c]));
          }
        }
      }
    }
    for (const geometry of [this.faces, this.inner, this.outline]) {
      for (const name of ["position", "color"]) geometry.attributes[name].needsUpdate = true;
      geometry.computeBoundingSphere();
    }
    this.faces.computeVertexNormals();
    this.edge = length / Math.max(1, inner.at / 6);
  }
  arrays(geometry) {
    return { position: geometry.attributes.position.array, color: geometry.attributes.color.array };
  }
}

class Viewer {
  constructor(place, data) {
    this.bodies = new Bodies(data);
    this.place = place;
    this.frame = element(place, "div", { className: "scene" });
    this.renderer = new three.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace;
    this.renderer.setClearColor(0xffffff);
    this.frame.append(this.renderer.domElement);
    this.shape = new Shape(this.bodies);
    this.plane = new three.Plane(new three.Vector3(-1, 0, 0), 0);
    this.scene = new three.Scene();
    this.addMeshes();
    this.scale = element(this.frame, "div", { className: "scale" });
    this.axes = this.frame.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
    this.addCamera();
    this.addControls();
    this.addPointer();
    this.showTime(this.bodies.first);
    new ResizeObserver(() => this.resize()).observe(place);
    this.resize();
    this.home();
  }
  addMeshes() {
    const Material = this.bodies.solid ? three.MeshLambertMaterial : three.MeshBasicMaterial;
    this.materials = [
      new Material({ vertexColors: true, side: three.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1,
        polygonOffsetUnits: 1 }),
      new three.LineBasicMaterial({ vertexColors: true }),
    ];
    this.mesh = new three.Mesh(this.shape.faces, this.materials[0]);
    this.mesh.frustumCulled = false;
    const [inner, outline] = [this.shape.inner, this.shape.outline].map((geometry) =>
      Object.assign(new three.LineSegments(geometry, this.materials[1]), { frustumCulled: false }));
    this.inner = inner;
    this.scene.add(this.mesh, inner, outline, new three.AmbientLight(0xffffff, 2.4));
    this.nearer = { value: 0 };  // in units of the depth that the camera sees, 2 in all
    this.bodies.marks.forEach((mark, order) => this.addDots(mark, order));
  }
  // Larger dots lie below smaller ones, both above the faces that they are on.
  addDots(mark, order) {
    const places = [];
    for (let i = 0; i < mark.place.length / this.bodies.components; ++i) {
      const [x, y, z] = this.bodies.point(mark.place, i);
      for (const mirror of this.shape.mirrors) places.push(mirror * x, y, z);
    }
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(new Float32Array(places), 3));
    const material = new three.PointsMaterial({ size: mark.size, sizeAttenuation: false, color: mark.colour });
    // Nearer by their own size, or a slanting face would cut them.
    material.onBeforeCompile = (shader) => {
      shader.uniforms.nearer = this.nearer;
      shader.vertexShader = "uniform float nearer;\n" +
        shader.vertexShader.replace("#include <project_vertex>", "#include <project_vertex>\ngl_Position.z -= nearer;");
    };
    this.materials.push(material);
    this.scene.add(Object.assign(new three.Points(geometry, material), { frustumCulled: false, renderOrder: order + 1 }));
  }
  addCamera() {
    const { solid, box } = this.bodies, size = Math.max(box.size, 1e-30);
    this.camera = new three.OrthographicCamera(-1, 1, 1, -1, 0, 20 * size);
    const light = new three.DirectionalLight(0xffffff, 0.8);
    light.position.set(-0.3, 1, 1);
    this.camera.add(light);
    this.scene.add(this.camera);
    const wide = box.high[0] - box.low[0], high = box.high[1] - box.low[1];
    this.turned = !solid && high > 1.2 * wide;
    if (solid) this.camera.up.set(0, 0, 1);
    else if (this.turned) this.camera.up.set(-1, 0, 0);
    this.controls = new three.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableRotate = solid;
    if (!solid) {
      this.controls.mouseButtons.LEFT = three.MOUSE.PAN;
      this.controls.touches.ONE = three.TOUCH.PAN;
    }
    this.controls.addEventListener("change", () => this.render());
  }
  addControls() {
    const { times, solid } = this.bodies;
    const time = element(this.place, "div", { className: "controls", hidden: times.length === 1 });
    this.playButton = element(time, "button", { textContent: "Play", onclick: () => this.play() });
    this.slider = element(time, "input", { type: "range", min: 0, max: times.length - 1, ariaLabel: "time",
      oninput: () => this.showTime(Number(this.slider.value)) });
    this.timeText = element(time, "output");
    const view = element(this.place, "div", { className: "controls" });
    element(view, "button", { textContent: "Whole", onclick: () => this.home() });
    for (const [text, factor] of [["+", 1.4], ["−", 1 / 1.4]])
      element(view, "button", { textContent: text, ariaLabel: text === "+" ? "nearer" : "farther", onclick: () => {
        this.camera.zoom *= factor;
        this.camera.updateProjectionMatrix();
        this.render();
      } });
    for (const contact of this.bodies.contacts())
      element(view, "button", { textContent: `Contact ${contact.name}`, className: "contact",
        onclick: () => this.lookAt(contact.centre, 1.5 * contact.size) });
    if (solid) this.addSection();
    if (solid && !this.bodies.kinds && this.bodies.bodies.length > 1) this.addBodies();
    element(view, "button", { textContent: "Save picture", onclick: () => this.save() });
    this.addLegend();
  }
  addSection() {
    const row = element(this.place, "div", { className: "controls" });
    const label = element(row, "label", { textContent: "Section across " });
    const axis = element(label, "select", { className: "section" });
    for (const text of ["none", "x", "y", "z"]) element(axis, "option", { textContent: text });
    const at = element(row, "input", { type: "range", min: 0, max: 1, step: 0.01, value: 0.5, ariaLabel: "section" });
    const text = element(row, "output");
    const cut = () => {
      const c = ["x", "y", "z"].indexOf(axis.value), { low, high } = this.bodies.box;
      for (const material of this.materials) material.clippingPlanes = c < 0 ? null : [this.plane];
      this.renderer.localClippingEnabled = c >= 0;
      at.disabled = c < 0;
      if (c >= 0) {
        const x = low[c] + Number(at.value) * (high[c] - low[c]), side = c === 0 ? -1 : c === 1 ? 1 : -1;
        this.plane.normal.set(...[0, 1, 2].map((k) => (k === c ? side : 0)));
        this.plane.constant = -side * x;
        text.textContent = `${axis.value} = ${x.toPrecision(3)} m`;
      } else {
        text.textContent = "";
      }
      this.render();
    };
    axis.onchange = at.oninput = cut;
    at.disabled = true;
  }
  // A body hides the surface of the other one that it presses.
  addBodies() {
    const label = element(element(this.place, "div", { className: "controls" }), "label", { textContent: "Bodies " });
    const choice = element(label, "select", { className: "bodies", onchange: () => {
      this.bodies.shown = choice.selectedIndex - 1;
      this.showTime(this.time);
    } });
    for (const name of ["all", ...this.bodies.bodies.map((body) => body.name)]) element(choice, "option", { textContent: name });
  }
  addLegend() {
    const { kinds, fields } = this.bodies;
    if (kinds) return this.addKinds();
    if (fields.length > 1) {
      const label = element(element(this.place, "div", { className: "controls" }), "label", { textContent: "Colours " });
      const field = element(label, "select", { className: "field", onchange: () => this.showField(field.selectedIndex) });
      for (const { name } of fields) element(field, "option", { textContent: name });
    }
    this.legend = element(this.place, "div", { className: "legend" });
    this.fillLegend();
  }
  fillLegend() {
    const { hex, field: { name, signed, high, factor, unit } } = this.bodies;
    this.legend.replaceChildren();
    element(this.legend, "span", { textContent: `${name} [${unit}]` });
    element(this.legend, "div").style.background = `linear-gradient(to right, ${hex.join(", ")})`;
    const numbers = element(this.legend, "p"), low = signed ? -1 : 0;
    for (let i = 0; i <= 4; ++i)
      element(numbers, "span", { textContent: Number(((low + i * (1 - low) / 4) * high * factor).toPrecision(3)) });
  }
  showField(index) {
    this.bodies.showField(index);
    this.fillLegend();
    this.showTime(this.time);
  }
  addKinds() {
    const legend = element(this.place, "div", { className: "legend kinds" });
    const kinds = this.bodies.kinds.filter((_, k) => this.bodies.pieces.some((piece) => piece.kind.includes(k)));
    for (const [entries, className] of [[kinds, "kind"], [this.bodies.marks, "mark"]])
      for (const { name, colour } of entries)
        element(legend, "span", { className, textContent: name }).style.setProperty("--colour", colour);
  }
  // The pointer finds what is said of the element below it.
  addPointer() {
    const canvas = this.renderer.domElement, ray = new three.Raycaster(), text = element(this.frame, "div", { className: "pointed" });
    text.hidden = true;
    canvas.addEventListener("pointermove", (event) => {
      const x = event.offsetX, y = event.offsetY;
      ray.setFromCamera(new three.Vector2(2 * x / this.width - 1, 1 - 2 * y / this.height), this.camera);
      const hit = event.buttons ? null : ray.intersectObject(this.mesh).find((h) =>
        !this.materials[0].clippingPlanes || this.plane.distanceToPoint(h.point) >= 0);
      text.hidden = !hit;
      if (!hit) return;
      text.textContent = this.bodies.says(...this.shape.owners[hit.faceIndex], this.time);
      text.style.left = `${Math.min(x + 12, Math.max(0, this.width - 260))}px`;
      text.style.top = `${Math.min(y + 12, this.height - 30)}px`;
    });
    canvas.addEventListener("pointerleave", () => { text.hidden = true; });
  }
  showTime(time) {
    this.time = time;
    this.slider.value = time;
    this.timeText.textContent = this.bodies.times[time];
    this.shape.show(time);
    this.render();
  }
  play() {
    if (this.playing) {
      clearInterval(this.playing);
      this.playing = null;
    } else {
      this.playing = setInterval(() => this.showTime((this.time + 1) % this.bodies.times.length), 600);
    }
    this.playButton.textContent = this.playing ? "Stop" : "Play";
  }
  lookAt(centre, size) {
    const away = this.bodies.solid ? [0.4, -0.8, 0.45] : [0, 0, 1];
    const far = 8 * Math.max(this.bodies.box.size, 1e-30) / Math.hypot(...away);
    this.controls.target.set(...centre);
    this.camera.position.set(...centre.map((x, c) => x + far * away[c]));
    this.camera.zoom = Math.min(this.width, this.height) / size;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.render();
  }
  home() {
    this.lookAt(this.bodies.box.centre, this.bodies.box.size);
    // From its own extent on the screen: a long rod fills the width.
    let right = 0, up = 0;
    const x = new three.Vector3(), { low, high } = this.bodies.box, strip = this.bodies.model === "bar" ? 0.02 * this.bodies.box.size : 0;
    for (let corner = 0; corner < 8; ++corner) {
      x.set(...[0, 1, 2].map((c) => ((corner >> c) & 1 ? high[c] : low[c]))).project(this.camera);
      right = Math.max(right, Math.abs(x.x) + strip);
      up = Math.max(up, Math.abs(x.y) + strip);
    }
    this.camera.zoom *= 0.85 / Math.max(right, up, 1e-9);
    this.camera.updateProjectionMatrix();
    this.render();
  }
  resize() {
    const width = this.place.clientWidth;
    if (width === 0 || width === this.width) return;
    const before = Math.min(this.width ?? 0, 2.2 * (this.height ?? 0));
    this.width = width;
    this.height = Math.round(Math.min(0.5 * width + 60, 480));
    if (before > 0) this.camera.zoom *= Math.min(width, 2.2 * this.height) / before;  // the same bodies stay in sight
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, this.height);
    Object.assign(this.camera, { left: -width / 2, right: width / 2, top: this.height / 2, bottom: -this.height / 2 });
    this.camera.updateProjectionMatrix();
    this.render();
  }
  render() {
    if (!this.width) return;
    this.inner.visible = this.shape.edge * this.camera.zoom >= 6;  // closer together they would hide the colours
    this.nearer.value = 20 / this.camera.zoom / (this.camera.far - this.camera.near);
    this.renderer.render(this.scene, this.camera);
    this.drawScale();
    this.drawAxes();
  }
  // The camera's zoom is pixels per metre; of solids the length holds across the line of sight.
  drawScale() {
    const most = 120 / this.camera.zoom, power = 10 ** Math.floor(Math.log10(most));
    const length = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
    this.scale.style.width = `${length * this.camera.zoom}px`;
    const [factor, unit] = length >= 1 ? [1, "m"] : length >= 1e-3 ? [1e3, "mm"] : length >= 1e-6 ? [1e6, "µm"] : [1e9, "nm"];
    this.scale.textContent = `${Number((length * factor).toPrecision(1))} ${unit}`;
  }
  drawAxes() {
    const letters = { bar: "x", plane_strain: "xy", axisymmetric: "rz", solid: "xyz" }[this.bodies.model];
    this.axes.setAttribute("width", 70);
    this.axes.setAttribute("height", 70);
    const inverse = this.camera.quaternion.clone().invert();
    this.axes.innerHTML = [...letters].map((letter, c) => {
      const direction = new three.Vector3(...[0, 1, 2].map((k) => (k === c ? 1 : 0))).applyQuaternion(inverse);
      const [x, y] = [direction.x, -direction.y];
      return `<line x1="35" y1="35" x2="${35 + 20 * x}" y2="${35 + 20 * y}" stroke="#111" stroke-width="1.5"/>` +
        `<text x="${35 + 28 * x}" y="${39 + 28 * y}" text-anchor="middle">${letter}</text>`;
    }).join("");
  }
  save() {
    this.render();
    Object.assign(document.createElement("a"), { href: this.renderer.domElement.toDataURL("image/png"),
      download: "deformed_bodies.png" }).click();
  }
}

function drawBodies() {
  const place = document.getElementById("deformed_bodies");
  three.ColorManagement.enabled = false;
  const canvas = document.createElement("canvas");
  if (!canvas.getContext("webgl2")) {
    place.textContent = "This browser has no WebGL 2, which draws the bodies. Switch it on, or open the fields in ParaView.";
    return null;
  }
  try {
    return new Viewer(place, JSON.parse(document.getElementById("bodies").textContent));
  } catch (error) {
    place.textContent = "The bodies could not be drawn: " + error.message;
    console.error(error);
    return null;
  }
}

const bodyViewer = drawBodies();
