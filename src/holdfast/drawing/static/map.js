"use strict";
// The map of a page: drag to turn, wheel to come nearer, shift or the right button to move; arrow keys and + - likewise.
(async function () {
  const OPENING = Math.tan(15 * Math.PI / 180); // half the height of the picture over its distance
  const plot = document.getElementById("plot"), canvas = plot.querySelector("canvas");
  const hover = document.getElementById("hover"), badges = document.getElementById("badges");

  // ---- data: a deflated header with arrays behind it (packed.py) ----
  async function read(text) {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const whole = await new Response(stream).arrayBuffer();
    const length = new DataView(whole).getUint32(0, true);
    const kinds = {f4: Float32Array, u1: Uint8Array};
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(whole, 4, length)));
    const filled = value => {
      if (Array.isArray(value)) return value.map(filled);
      if (value === null || typeof value !== "object") return value;
      if (value.kind === "u4") { // all lowest bytes first
        const n = value.count, bytes = new Uint8Array(whole, 4 + length + value.at, 4 * n), found = new Uint32Array(n);
        for (let k = 0; k < n; k++) found[k] = bytes[k] | bytes[n + k] << 8 | bytes[2 * n + k] << 16 | bytes[3 * n + k] << 24;
        return found;
      }
      if ("at" in value && "kind" in value) return new kinds[value.kind](whole, 4 + length + value.at, value.count);
      return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, filled(item)]));
    };
    return filled(header);
  }
  const data = await read(document.getElementById("data").textContent);

  // ---- vectors ----
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const plus = (a, b, t) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = a => { const n = Math.hypot(...a); return [a[0] / n, a[1] / n, a[2] / n]; };

  // ---- camera: looks at ``target`` from ``distance`` along ``toward``, which points from the scene to the viewer ----
  const up = unit(data.up), middle = [0, 1, 2].map(k => (data.bounds[0][k] + data.bounds[1][k]) / 2);
  const size = Math.hypot(...[0, 1, 2].map(k => data.bounds[1][k] - data.bounds[0][k])) || 1;
  const camera = {target: middle, toward: data.views.front, distance: 3 * size};
  let framed = 0;
  function axes() {
    const right = unit(cross(up, camera.toward));
    return [right, cross(camera.toward, right), camera.toward];
  }
  function frame(toward) { // come as near as shows all that has to be seen
    camera.toward = toward;
    const [right, top] = axes(), wide = OPENING * canvas.width / canvas.height;
    const seen = [];
    for (let k = 0; k < data.shown.length; k += 3) {
      const p = plus(Array.from(data.shown.subarray(k, k + 3)), middle, -1);
      seen.push([dot(p, right), dot(p, top), dot(p, toward)]);
    }
    camera.target = middle;
    const reach = seen.map(([x, y, z]) => Math.max(Math.abs(x) / wide, Math.abs(y) / OPENING) + z);
    camera.distance = 1.08 * Math.max(...reach, 1e-9);
    framed = camera.distance;
  }
  function turn(level, rise) {
    const [right, top] = axes(), tilt = Math.asin(Math.max(-1, Math.min(1, dot(camera.toward, up))));
    const flat = unit(plus(camera.toward, up, -dot(camera.toward, up))), side = cross(up, flat);
    const to = Math.max(-1.55, Math.min(1.55, tilt + rise));
    const level2 = plus(flat.map(v => v * Math.cos(level)), side, Math.sin(level));
    camera.toward = unit(plus(level2.map(v => v * Math.cos(to)), up, Math.sin(to)));
  }
  function move(x, y) { // by pixels
    const [right, top] = axes(), step = 2 * OPENING * camera.distance / plot.clientHeight;
    camera.target = plus(plus(camera.target, right, -x * step), top, y * step);
  }
  function matrix() { // column-major: world to clip space
    const [right, top, toward] = axes(), eye = plus(camera.target, toward, camera.distance);
    const aspect = canvas.width / canvas.height, near = camera.distance / 50, far = camera.distance + 20 * size;
    const rows = [right.map(v => v / (OPENING * aspect)), top.map(v => v / OPENING)];
    const a = (far + near) / (far - near), b = 2 * far * near / (far - near);
    const m = [[...rows[0], -dot(rows[0], eye)], [...rows[1], -dot(rows[1], eye)],
      [...toward.map(v => -a * v), a * dot(toward, eye) - b], [...toward.map(v => -v), dot(toward, eye)]];
    return new Float32Array([0, 1, 2, 3].flatMap(column => m.map(row => row[column])));
  }

  // ---- drawing: colours are shown as they are, without light, so that they can be compared with the legend ----
  const gl = canvas.getContext("webgl2", {antialias: true, alpha: false});
  if (!gl) { plot.textContent = "This page draws with WebGL 2, which this browser does not offer."; return; }
  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    return name => name ? gl.getUniformLocation(made, name) : gl.useProgram(made);
  }
  const faces = program(
    `uniform mat4 view; layout(location=0) in vec3 place; layout(location=1) in vec4 paint;
     layout(location=2) in vec4 name; flat out vec4 colour; flat out vec4 number; out vec3 at;
     void main() { gl_Position = view * vec4(place, 1.0); colour = paint; number = name; at = place; }`,
    `uniform float opacity; uniform bool naming; uniform vec4 fade; uniform float dense;
     flat in vec4 colour; flat in vec4 number; in vec3 at; out vec4 shown;
     void main() {
       if (naming) { shown = number; return; }
       vec3 rgb = colour.rgb;
       if (colour.a > 0.0 && mod(gl_FragCoord.x + gl_FragCoord.y, 10.0 * dense) < 2.0 * dense) rgb *= 0.62;
       float far = fade.w > 0.0 ? smoothstep(0.6, 1.3, distance(at, fade.xyz) / fade.w) : 0.0;
       shown = vec4(mix(rgb, vec3(1.0), far), opacity); }`);
  const lines = program(
    `uniform mat4 view; uniform vec2 screen; uniform float width; layout(location=0) in vec3 from;
     layout(location=1) in vec3 to; out vec3 at;
     void main() {
       vec4 a = view * vec4(from, 1.0), b = view * vec4(to, 1.0);
       vec2 along = (b.xy / b.w - a.xy / a.w) * screen;
       along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
       float end = float(gl_VertexID / 2), side = float(gl_VertexID % 2) - 0.5;
       vec4 p = end > 0.0 ? b : a;
       p.xy += p.w * vec2(-along.y, along.x) * side * 2.0 * width / screen;
       p.z -= 2e-4 * p.w; gl_Position = p; at = end > 0.0 ? to : from; }`,
    `uniform vec3 colour; uniform vec4 fade; in vec3 at; out vec4 shown;
     void main() { float far = fade.w > 0.0 ? smoothstep(0.6, 1.3, distance(at, fade.xyz) / fade.w) : 0.0;
       shown = vec4(mix(colour, vec3(1.0), far), 1.0); }`);
  const dots = program(
    `uniform mat4 view; uniform float width; layout(location=0) in vec3 place;
     void main() { gl_Position = view * vec4(place, 1.0); gl_Position.z -= 4e-4 * gl_Position.w; gl_PointSize = width; }`,
    `uniform vec3 colour; out vec4 shown;
     void main() { if (length(gl_PointCoord - 0.5) > 0.5) discard; shown = vec4(colour, 1.0); }`);

  function buffer(values, target = gl.ARRAY_BUFFER) {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, values, gl.STATIC_DRAW);
    return made;
  }
  const texts = [""]; // text number 0: nothing
  function load(part) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    buffer(part.vertices);
    if (part.shape === "lines") {
      for (const k of [0, 1]) {
        gl.enableVertexAttribArray(k);
        gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * k);
        gl.vertexAttribDivisor(k, 1);
      }
    } else {
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    }
    if (part.shape === "faces") {
      const count = part.cell.length, paint = new Uint8Array(4 * count), name = new Uint8Array(4 * count), first = texts.length;
      for (const text of part.texts) texts.push(text);
      for (let k = 0; k < count; k++) {
        const cell = part.cell[k], number = part.texts[cell] ? first + cell : 0;
        paint.set(part.paint.subarray(4 * cell, 4 * cell + 4), 4 * k);
        name.set([number & 255, number >> 8 & 255, number >> 16 & 255, 255], 4 * k);
      }
      for (const [k, values] of [[1, paint], [2, name]]) {
        buffer(values);
        gl.enableVertexAttribArray(k);
        gl.vertexAttribPointer(k, 4, gl.UNSIGNED_BYTE, true, 0, 0);
      }
      buffer(part.triangles, gl.ELEMENT_ARRAY_BUFFER);
    }
    gl.bindVertexArray(null);
    const count = part.shape === "faces" ? part.triangles.length : part.vertices.length / (part.shape === "lines" ? 6 : 3);
    return {...part, array, count};
  }
  const layers = data.layers.map(layer => ({...layer, shown: true, parts: layer.parts.map(load)}));
  let glass = false;

  const screen = gl.createFramebuffer(), names = gl.createTexture(), depth = gl.createRenderbuffer();
  function fit() {
    const dense = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(plot.clientWidth * dense));
    canvas.height = Math.max(1, Math.round(plot.clientHeight * dense));
    gl.bindTexture(gl.TEXTURE_2D, names);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, canvas.width, canvas.height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, canvas.width, canvas.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, screen);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, names, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
  function each(shape, draw) {
    for (const layer of layers) {
      if (!layer.shown) continue;
      for (const part of layer.parts) if (part.shape === shape) {
        gl.bindVertexArray(part.array);
        draw(part, layer.role === "fixed" ? [...middle, 1.2 * size] : [0, 0, 0, 0], layer.role);
      }
    }
  }
  function paintFaces(view, naming) {
    faces();
    gl.uniformMatrix4fv(faces("view"), false, view);
    gl.uniform1i(faces("naming"), naming);
    gl.uniform1f(faces("dense"), window.devicePixelRatio || 1);
    for (const solid of [false, true]) {
      const clear = glass && solid && !naming;
      gl.depthMask(!clear);
      if (clear) { gl.enable(gl.BLEND); } else { gl.disable(gl.BLEND); }
      each("faces", (part, fade) => {
        if (part.solid !== solid) return;
        gl.uniform1f(faces("opacity"), clear ? 0.3 : 1);
        gl.uniform4fv(faces("fade"), fade);
        gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
      });
    }
    gl.depthMask(true);
    gl.enable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    if (!naming) each("faces", (part, fade, role) => { // pushes shine through what hides them: no badge floats
      if (role !== "pushes") return;
      gl.uniform1f(faces("opacity"), 0.38);
      gl.uniform4fv(faces("fade"), fade);
      gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
    });
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
  }
  function spread(places) { // badges [px] moved until none covers another
    for (let round = 0; round < 50; round++) places.forEach((p, k) => places.slice(0, k).forEach((q, j) => {
      const way = [p[0] - q[0], p[1] - q[1]], far = Math.hypot(...way), lacks = Math.max(0, 24 - far) / 2;
      const [x, y] = far > 0.01 ? way.map(v => v / far) : [Math.cos(k + j), Math.sin(k + j)];
      p[0] += lacks * x; p[1] += lacks * y; q[0] -= lacks * x; q[1] -= lacks * y;
    }));
    return places;
  }
  function draw() {
    const view = matrix(), dense = window.devicePixelRatio || 1;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    paintFaces(view, false);
    lines();
    gl.uniformMatrix4fv(lines("view"), false, view);
    gl.uniform2f(lines("screen"), canvas.width, canvas.height);
    each("lines", (part, fade) => {
      gl.uniform1f(lines("width"), part.width * dense);
      gl.uniform3fv(lines("colour"), part.colour);
      gl.uniform4fv(lines("fade"), fade);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, part.count);
    });
    dots();
    gl.uniformMatrix4fv(dots("view"), false, view);
    each("dots", part => {
      gl.uniform1f(dots("width"), part.width * dense);
      gl.uniform3fv(dots("colour"), part.colour);
      gl.drawArrays(gl.POINTS, 0, part.count);
    });
    spread(data.badges.map(p => {
      const [x, y, , w] = [0, 1, 2, 3].map(r => view[r] * p[0] + view[4 + r] * p[1] + view[8 + r] * p[2] + view[12 + r]);
      return [plot.clientWidth / 2 * (1 + x / w), plot.clientHeight / 2 * (1 - y / w)];
    })).forEach(([x, y], k) => {
      badges.children[k].style.left = `${x}px`;
      badges.children[k].style.top = `${y}px`;
    });
  }
  function textAt(x, y) { // under a point of the plot [px]: every cell is drawn in a colour that is its number
    gl.bindFramebuffer(gl.FRAMEBUFFER, screen);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    paintFaces(matrix(), true);
    const found = new Uint8Array(4), dense = canvas.width / plot.clientWidth;
    gl.readPixels(Math.floor(x * dense), canvas.height - 1 - Math.floor(y * dense), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return texts[found[0] + 256 * found[1] + 65536 * found[2]];
  }
  let waiting = null;
  function again(pointer) { // at most once a frame
    if (!waiting) requestAnimationFrame(() => {
      const where = waiting.pointer;
      waiting = null;
      draw();
      const text = where && !held.size ? textAt(...where) : "";
      hover.style.display = text ? "block" : "none";
      if (text) {
        hover.innerHTML = text; // names in it are escaped where the map is made
        const left = Math.min(where[0] + 14, plot.clientWidth - hover.offsetWidth - 6);
        hover.style.left = `${left}px`;
        hover.style.top = `${where[1] + 18 + hover.offsetHeight > plot.clientHeight ? where[1] - hover.offsetHeight - 10 : where[1] + 18}px`;
      }
    });
    waiting = {pointer};
  }

  // ---- hands ----
  const held = new Map();
  const placed = event => [event.offsetX, event.offsetY];
  canvas.onpointerdown = event => { canvas.setPointerCapture(event.pointerId); held.set(event.pointerId, placed(event)); again(); };
  canvas.onpointerup = canvas.onpointercancel = event => { held.delete(event.pointerId); again(placed(event)); };
  canvas.onpointerleave = () => { if (!held.size) again(); };
  canvas.oncontextmenu = event => event.preventDefault();
  canvas.onpointermove = event => {
    const was = held.get(event.pointerId), now = placed(event);
    if (!was) { again(now); return; }
    held.set(event.pointerId, now);
    const by = [now[0] - was[0], now[1] - was[1]];
    const other = [...held].filter(([id]) => id !== event.pointerId).map(([, at]) => at)[0];
    if (other) { // two fingers: nearer and farther
      const apart = at => Math.hypot(at[0] - other[0], at[1] - other[1]) || 1;
      camera.distance *= apart(was) / apart(now);
      move(by[0] / 2, by[1] / 2);
    } else if (event.shiftKey || event.buttons & 6) { move(...by); }
    else { turn(-by[0] * 0.008, by[1] * 0.008); }
    again();
  };
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    camera.distance *= Math.exp(Math.max(-80, Math.min(80, event.deltaY)) * 0.002);
    again();
  }, {passive: false});
  canvas.onkeydown = event => {
    const steps = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1]}[event.key];
    if (steps && event.shiftKey) move(steps[0] * -200, steps[1] * 200);
    else if (steps) turn(...steps);
    else if (event.key === "+" || event.key === "=") camera.distance /= 1.15;
    else if (event.key === "-") camera.distance *= 1.15;
    else return;
    event.preventDefault();
    again();
  };
  function show(box) {
    const layer = layers[Number(box.dataset.layer)];
    layer.shown = box.checked;
    if (layer.role === "pushes") badges.hidden = !box.checked;
    again();
  }
  document.querySelectorAll("input[data-layer]").forEach(box => { box.onchange = () => show(box); });
  document.getElementById("glass").onchange = event => { glass = event.target.checked; again(); };
  document.querySelectorAll("button[data-view]").forEach(button => {
    button.onclick = () => { // what stands on a floor is seen from below only without it
      const fixed = document.querySelector("input[data-role=fixed]"), above = button.dataset.view === "front";
      if (fixed && fixed.checked !== above) { fixed.checked = above; show(fixed); }
      frame(data.views[button.dataset.view]);
      again();
    };
  });
  document.getElementById("save").onclick = () => {
    draw();
    const link = document.createElement("a");
    link.href = canvas.toDataURL("image/png");
    link.download = "map.png";
    link.click();
  };
  data.badges.forEach((_, k) => {
    const badge = document.createElement("b");
    badge.textContent = String(k + 1);
    badges.append(badge);
  });
  new ResizeObserver(() => {
    fit();
    if (camera.distance === framed && camera.target === middle) frame(camera.toward); // nobody has come nearer or moved
    draw();
  }).observe(plot);
  fit();
  frame(data.views.front);
  draw();
})();
