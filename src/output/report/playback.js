// The playback: unpacks the animation (see playback.rs), draws it with WebGL 2, follows keyboard, mouse and fingers.
"use strict";
(() => {
  const find = (id) => document.getElementById(id);
  const root = document.documentElement;
  const say = (state) => { root.dataset.playback = state; };
  if (!find("animation")) return say("none");
  const animation = JSON.parse(find("animation").textContent);
  const count = animation.times.length;
  const WIDE = 256; // nodes and cells in a row of their textures
  const canvas = find("scene");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl || !window.DecompressionStream) return say("unsupported");

  const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const inflated = async (bytes) =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());

  // Positions [mm] and places among the yarns of all nodes at each time, tensions of all cells at each time.
  function unpack(bytes) {
    const plies = animation.plies.map((s) => ({ across: s.columns.length, up: s.rows.length, ...s }));
    let nodes = 0, cells = 0;
    for (const s of plies) {
      Object.assign(s, { node: nodes, cell: cells, cells: (s.across - 1) * (s.up - 1) });
      nodes += s.across * s.up;
      cells += s.cells;
    }
    let at = 0;
    const words = () => {
      const out = new Int16Array(nodes);
      for (let n = 0; n < nodes; n++) out[n] = bytes[at + n] | (bytes[at + nodes + n] << 8);
      at += 2 * nodes;
      return out;
    };
    const rest = [words(), words(), words()];
    const moved = [0, 1, 2].map(() => new Int16Array(nodes));
    const size = WIDE * Math.ceil(nodes / WIDE);
    // Where a node lies among the yarns, across the weft and across the warp.
    const yarns = [new Float32Array(nodes), new Float32Array(nodes)];
    for (const s of plies)
      for (let row = 0; row < s.up; row++)
        for (let column = 0; column < s.across; column++) {
          yarns[0][s.node + row * s.across + column] = s.columns[column];
          yarns[1][s.node + row * s.across + column] = s.rows[row];
        }
    const places = animation.times.map(() => {
      const out = new Float32Array(4 * size);
      for (let axis = 0; axis < 3; axis++) {
        const change = words();
        for (let n = 0; n < nodes; n++) {
          moved[axis][n] += change[n];
          out[4 * n + axis] = 1e3 * (rest[axis][n] * animation.step.reference + moved[axis][n] * animation.step.displacement);
        }
      }
      for (let n = 0; n < nodes; n++) out[4 * n + 3] = yarns[0][n];
      return out;
    });
    const flat = new Float32Array(4 * size);
    for (let n = 0; n < nodes; n++) flat[4 * n + 3] = yarns[1][n];
    for (let axis = 0; axis < 3; axis++)
      for (let n = 0; n < nodes; n++) flat[4 * n + axis] = 1e3 * rest[axis][n] * animation.step.reference;
    const last = new Uint8Array(2 * cells);
    const loads = animation.times.map(() => {
      const out = new Uint8Array(2 * WIDE * Math.ceil(cells / WIDE));
      for (let yarn = 0; yarn < 2; yarn++)
        for (let n = 0; n < cells; n++) out[2 * n + yarn] = last[2 * n + yarn] += bytes[at++];
      return out;
    });
    return { plies, nodes, cells, flat, places, loads };
  }

  // Where the fabric goes [mm]: largest deflection, how far from the impact it moves, and where the projectile is at the opening.
  function extent({ nodes, flat, places }) {
    const deepest = Math.max(animation.deepest, 1e-6);
    let moved = 8, whole = 8;
    for (let n = 0; n < nodes; n++) {
      const away = Math.hypot(flat[4 * n], flat[4 * n + 1]);
      whole = Math.max(whole, away);
      if (places.some((place) => Math.abs(place[4 * n + 2] - flat[4 * n + 2]) > 0.1 * deepest)) moved = Math.max(moved, away);
    }
    let [low, high] = [0, deepest];
    if (animation.body && animation.poses) {
      const [, , z, ...q] = animation.poses[animation.opening], r = turn(q);
      const heights = animation.body.points.flatMap((_, i, all) => i % 3 ? [] : [r[2] * all[i] + r[5] * all[i + 1] + r[8] * all[i + 2]]);
      low = Math.min(low, ...heights.map((h) => 1e3 * (z + animation.body.step * h)));
      high = Math.max(high, ...heights.map((h) => 1e3 * (z + animation.body.step * h)));
    }
    return { deepest, radius: Math.max(Math.min(1.15 * moved, whole), 0.6 * (high - low)), middle: 0.5 * (low + high) };
  }

  const HEAD = "#version 300 es\nprecision highp float; precision highp int; precision highp sampler2D;\n";
  const FABRIC = [`${HEAD}
    uniform sampler2D now, next, load, flat_; uniform float blend; uniform ivec4 ply; uniform vec2 mirror; uniform mat4 camera;
    out vec3 place; out vec2 yarn; flat out vec2 tension; out vec2 held;
    ivec2 at(int n) { return ivec2(n & 255, n >> 8); }
    int texel(ivec2 n) { return ply.x + n.y * ply.z + n.x; }
    vec3 node(ivec2 n) {
      return mix(texelFetch(now, at(texel(n)), 0).xyz, texelFetch(next, at(texel(n)), 0).xyz, blend);
    }
    vec3 rest(ivec2 n) { return texelFetch(flat_, at(texel(n)), 0).xyz; }
    vec2 yarns(ivec2 n) { return vec2(texelFetch(now, at(texel(n)), 0).w, texelFetch(flat_, at(texel(n)), 0).w); }
    vec2 carried(ivec2 cell) { return 255.0 * texelFetch(load, at(ply.y + cell.y * (ply.z - 1) + cell.x), 0).rg; }
    // Mean tension of the whole yarns in the cells around a node.
    vec2 around(ivec2 n) {
      vec2 sum = vec2(0.0), count = vec2(0.0);
      for (int i = 0; i < 4; i++) {
        ivec2 cell = n - ivec2(i & 1, i >> 1);
        if (min(cell.x, cell.y) < 0 || cell.x > ply.z - 2 || cell.y > ply.w - 2) continue;
        vec2 there = carried(cell), whole = vec2(lessThan(there, vec2(254.5)));
        sum += whole * there;
        count += whole;
      }
      return sum / max(count, 1.0);
    }
    // A cell is drawn in two halves, each on its own edge. Across broken yarns the edges do not hang together: there each half
    // is no wider than at rest, so that nothing spans the gap.
    void main() {
      const ivec2 corners[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(1, 1), ivec2(0, 0), ivec2(1, 1), ivec2(0, 1));
      int number = gl_VertexID / 12, side = (gl_VertexID / 6) % 2;
      ivec2 cell = ivec2(number % (ply.z - 1), number / (ply.z - 1)), corner = corners[gl_VertexID % 6];
      tension = carried(cell);
      bvec2 gone = greaterThan(tension, vec2(254.5));
      bool rows = gone.y && !gone.x;
      ivec2 own = cell + (rows ? ivec2(corner.x, side) : ivec2(side, corner.y));
      ivec2 other = cell + (rows ? ivec2(corner.x, 1 - side) : ivec2(1 - side, corner.y));
      float part = 0.5 * float(rows ? corner.y : corner.x);
      vec3 here = node(own), there = node(other);
      float width = distance(rest(own), rest(other)), stretched = distance(here, there);
      float reach = gone.x != gone.y ? min(1.0, width / max(stretched, 1e-6)) : 1.0;
      place = mix(here, there, reach * part) * vec3(mirror, 1.0);
      yarn = mix(yarns(own), yarns(other), part);
      vec2 across = yarns(cell + 1) - yarns(cell);
      held = max(across.x, across.y) > 1.01 ? mix(around(own), around(other), part) : tension;
      gl_Position = gone.x && gone.y ? vec4(0.0, 0.0, 2.0, 1.0) : camera * vec4(place, 1.0);
    }`, `${HEAD}
    uniform sampler2D colours; uniform int mode; uniform float deepest, cut; uniform vec3 light;
    in vec3 place; in vec2 yarn; flat in vec2 tension; in vec2 held; out vec4 colour;
    vec3 scale(float byte) { return texture(colours, vec2((byte + 0.5) / 256.0, 0.5)).rgb; }
    // Warp (0) or weft (1) in the colour asked for.
    vec3 paint(int which, float byte) {
      if (mode == 3) return scale(254.0 * clamp(abs(place.z) / deepest, 0.0, 1.0));
      return mode == 0 || mode == which + 1 ? scale(byte) : vec3(0.62);
    }
    void main() {
      if (cut > 0.5 && place.y < 0.0) discard;
      vec2 there = yarn, side = fract(there) - 0.5, size = fwidth(there);
      float fine = 1.0 - smoothstep(0.2, 0.5, max(size.x, size.y));
      bvec2 whole = lessThan(tension, vec2(254.5));
      // The warp runs along x, so that its yarn lies across y, and the other way round.
      bvec2 here = bvec2(whole.x && abs(side.y) < 0.45, whole.y && abs(side.x) < 0.45);
      if (max(size.x, size.y) < 0.1 && !any(here)) discard;
      bool over = mod(floor(there.x) + floor(there.y), 2.0) < 0.5;
      bool warp = here.x && (over || !here.y);
      float across = warp ? side.y : side.x, along = warp ? side.x : side.y;
      vec3 woven = paint(warp ? 0 : 1, warp ? held.x : held.y);
      woven *= (1.0 - 1.3 * across * across) * (over == warp ? 1.0 - 0.9 * along * along : 0.75);
      vec2 most = vec2(whole) * held;
      vec3 plain = mode == 2 ? paint(1, most.y) : mode == 1 ? paint(0, most.x) : paint(0, max(most.x, most.y));
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      float bright = 0.5 + 0.6 * abs(dot(normal, light));
      colour = vec4(bright * mix(plain, woven, fine), 1.0);
    }`];
  const BODY = [`${HEAD}
    uniform mat4 camera, pose; in vec3 point; out vec3 place;
    void main() { vec4 at = pose * vec4(point, 1.0); place = at.xyz; gl_Position = camera * at; }`, `${HEAD}
    uniform vec3 light; uniform float cut; in vec3 place; out vec4 colour;
    void main() {
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      colour = vec4(vec3(0.66, 0.58, 0.46) * (0.45 + 0.7 * abs(dot(normal, light))), 1.0);
    }`];

  function program([vertex, fragment]) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made) || "shader");
    return { made, at: (name) => gl.getUniformLocation(made, name) };
  }

  function texture(unit) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  }

  // 4 × 4 matrices, column by column.
  const product = (a, b) => Float32Array.from({ length: 16 }, (_, i) =>
    [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + (i % 4)] * b[4 * Math.floor(i / 4) + k], 0));
  const turn = ([w, x, y, z]) => [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];

  function start(data) {
    const size = extent(data);
    const VIEWS = [[-1.25, 0.26, 1.4], [-1.1, 0.42, 1], [-1.5708, 0.04, 1], [-1.1, 1.35, 1], [-1.1, -0.55, 1]]; // azimuth, elevation, zoom
    const view = { azimuth: 0, elevation: 0, zoom: 1 };
    let place = animation.opening, playing = false, touched = false, before = 0, uploaded = -1;

    const fabric = program(FABRIC), body = program(BODY);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    [0, 1, 2, 3, 4].forEach(texture);
    gl.activeTexture(gl.TEXTURE3);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, bytesOf(animation.colours));
    gl.activeTexture(gl.TEXTURE4);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, WIDE, data.flat.length / 4 / WIDE, 0, gl.RGBA, gl.FLOAT, data.flat);
    const [plain, solid] = [gl.createVertexArray(), gl.createVertexArray()];
    let triangles = 0;
    if (animation.body && animation.poses) {
      triangles = animation.body.triangles.length;
      gl.bindVertexArray(solid);
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(animation.body.points, (x) => 1e3 * animation.body.step * x), gl.STATIC_DRAW);
      const point = gl.getAttribLocation(body.made, "point");
      gl.enableVertexAttribArray(point);
      gl.vertexAttribPointer(point, 3, gl.FLOAT, false, 0, 0);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint16Array.from(animation.body.triangles), gl.STATIC_DRAW);
    }

    function upload(keyframe) {
      if (uploaded === keyframe) return;
      uploaded = keyframe;
      const next = Math.min(keyframe + 1, count - 1);
      for (const [unit, from] of [[0, keyframe], [1, next]]) {
        gl.activeTexture(gl.TEXTURE0 + unit);
        const numbers = data.places[from];
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, WIDE, numbers.length / 4 / WIDE, 0, gl.RGBA, gl.FLOAT, numbers);
      }
      gl.activeTexture(gl.TEXTURE2);
      const loads = data.loads[keyframe];
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG8, WIDE, loads.length / 2 / WIDE, 0, gl.RG, gl.UNSIGNED_BYTE, loads);
    }

    function camera() {
      const { azimuth: a, elevation: e } = view, ratio = canvas.width / canvas.height;
      const out = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
      const right = [-Math.sin(a), Math.cos(a), 0];
      const up = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
      const far = (3.7 * size.radius * Math.max(1, 1.25 / ratio)) / view.zoom;
      const target = [0, 0, size.middle];
      const eye = target.map((t, i) => t + far * out[i]);
      const dot = (v) => -(v[0] * eye[0] + v[1] * eye[1] + v[2] * eye[2]);
      const look = [right[0], up[0], out[0], 0, right[1], up[1], out[1], 0, right[2], up[2], out[2], 0, dot(right), dot(up), dot(out), 1];
      const near = 0.05 * far, end = far + 20 * size.radius, focus = 3.4;
      const lens = [focus / ratio, 0, 0, 0, 0, focus, 0, 0, 0, 0, (end + near) / (near - end), -1, 0, 0, (2 * end * near) / (near - end), 0];
      return { matrix: product(lens, look), light: out.map((o, i) => 0.8 * o + 0.5 * up[i] + 0.33 * right[i]) };
    }

    // Straight between two poses; rotations are small from one to the next.
    function pose(keyframe, blend) {
      const [from, to] = [animation.poses[keyframe], animation.poses[Math.min(keyframe + 1, count - 1)]];
      const mixed = from.map((x, i) => x + blend * (to[i] - x));
      const norm = Math.hypot(...mixed.slice(3));
      const r = turn(mixed.slice(3).map((x) => x / norm));
      return [r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 1e3 * mixed[0], 1e3 * mixed[1], 1e3 * mixed[2], 1];
    }

    // The canvas as it lies on the page, or of a given size on white paper.
    function draw(paper) {
      const pixels = Math.min(window.devicePixelRatio || 1, 2);
      const [width, height] = paper || [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * pixels)));
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      const keyframe = Math.min(Math.floor(place), count - 1), blend = place - keyframe;
      upload(keyframe);
      const ink = paper ? [1, 1, 1] : getComputedStyle(canvas).backgroundColor.match(/[\d.]+/g).map((x) => x / 255);
      gl.viewport(0, 0, width, height);
      gl.clearColor(ink[0], ink[1], ink[2], 1);
      gl.enable(gl.DEPTH_TEST);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      const { matrix, light } = camera();
      const cut = find("cut").checked ? 1 : 0;
      gl.useProgram(fabric.made);
      ["now", "next", "load", "colours", "flat_"].forEach((name, unit) => gl.uniform1i(fabric.at(name), unit));
      gl.uniform1f(fabric.at("blend"), blend);
      gl.uniform1f(fabric.at("cut"), cut);
      gl.uniform1f(fabric.at("deepest"), size.deepest);
      gl.uniform1i(fabric.at("mode"), Number(find("colour").value));
      gl.uniform3fv(fabric.at("light"), light);
      gl.uniformMatrix4fv(fabric.at("camera"), false, matrix);
      gl.bindVertexArray(plain);
      for (const x of animation.mirror[0] ? [1, -1] : [1])
        for (const y of animation.mirror[1] ? [1, -1] : [1])
          for (const s of data.plies) {
            gl.uniform2f(fabric.at("mirror"), x, y);
            gl.uniform4i(fabric.at("ply"), s.node, s.cell, s.across, s.up);
            gl.drawArrays(gl.TRIANGLES, 0, 12 * s.cells);
          }
      if (triangles) {
        gl.useProgram(body.made);
        gl.uniformMatrix4fv(body.at("camera"), false, matrix);
        gl.uniformMatrix4fv(body.at("pose"), false, pose(keyframe, blend));
        gl.uniform3fv(body.at("light"), light);
        gl.bindVertexArray(solid);
        gl.drawElements(gl.TRIANGLES, triangles, gl.UNSIGNED_SHORT, 0);
      }
      show();
    }

    // Clock, slider, and the mark in every figure over time.
    const marks = [...document.querySelectorAll("svg[data-time]")].map((svg) => {
      const [from, to, left, right] = svg.dataset.time.split(" ").map(Number);
      const frame = svg.querySelector(".frame"), line = document.createElementNS(svg.namespaceURI, "line");
      const [top, high] = [Number(frame.getAttribute("y")), Number(frame.getAttribute("height"))];
      line.setAttribute("class", "now");
      line.setAttribute("y1", top);
      line.setAttribute("y2", top + high);
      svg.append(line);
      svg.addEventListener("click", (event) => {
        const box = svg.getBoundingClientRect();
        const x = ((event.clientX - box.left) / box.width) * svg.viewBox.baseVal.width;
        goto(keyframeAt(from + ((x - left) / (right - left)) * (to - from)));
      });
      return { line, at: (time) => left + ((time - from) / (to - from)) * (right - left) };
    });
    function keyframeAt(time) {
      const after = animation.times.findIndex((t) => t >= time);
      if (after < 1) return after === 0 ? 0 : count - 1;
      return after - 1 + (time - animation.times[after - 1]) / (animation.times[after] - animation.times[after - 1]);
    }
    function timeAt(where) {
      const keyframe = Math.min(Math.floor(where), count - 1);
      return animation.times[keyframe] + (where - keyframe) * (animation.times[Math.min(keyframe + 1, count - 1)] - animation.times[keyframe]);
    }
    function show() {
      const time = timeAt(place);
      find("clock").textContent = `${time.toFixed(1)} µs`;
      find("scrub").value = place;
      find("scrub").setAttribute("aria-valuetext", `${time.toFixed(1)} microseconds`);
      for (const { line, at } of marks) for (const end of ["x1", "x2"]) line.setAttribute(end, at(time));
      canvas.dataset.place = place.toFixed(3);
    }

    let waiting = 0;
    function request() { waiting ||= requestAnimationFrame(tick); }
    function tick(time) {
      waiting = 0;
      if (playing) {
        // The whole animation in eight seconds. A frame's time may lie before that of the key that started it.
        const passed = Math.min(Math.max(time - before, 0), 100);
        // Pictures need not lie evenly to the step.
        place = keyframeAt(timeAt(place) + (passed / 8000) * (animation.times[count - 1] - animation.times[0]));
        before = time;
        if (place >= count - 1) play(false);
        else request();
      }
      draw();
    }
    function goto(where) { touched = true; place = Math.min(Math.max(where, 0), count - 1); request(); }
    function play(on) {
      if (on && (!touched || place >= count - 1)) place = 0;
      touched = true;
      playing = on;
      before = performance.now();
      find("play").textContent = on ? "Pause" : "Play";
      find("play").setAttribute("aria-pressed", on);
      request();
    }
    function step(by) { play(false); goto(Math.round(place) + by); }
    function zoom(by) { view.zoom = Math.min(Math.max(view.zoom * by, 0.3), 12); request(); }
    function stand(at) { 
      [view.azimuth, view.elevation, view.zoom] = VIEWS[at];
      find("cut").checked = at === 0;
      request();
    }

    find("scrub").max = count - 1;
    find("scrub").addEventListener("input", () => { play(false); goto(Number(find("scrub").value)); });
    find("play").addEventListener("click", () => play(!playing));
    find("view").addEventListener("change", () => stand(Number(find("view").value)));
    find("cut").addEventListener("change", request);
    find("colour").addEventListener("change", () => {
      const deep = find("colour").value === "3";
      find("low").textContent = deep ? "0 mm" : "0 N";
      find("high").textContent = deep ? `${size.deepest.toPrecision(3)} mm` : find("high").dataset.tension;
      request();
    });
    const KEYS = {
      " ": () => play(!playing), ArrowRight: () => step(1), ArrowLeft: () => step(-1), Home: () => step(-count), End: () => step(count),
      "+": () => zoom(1.25), "=": () => zoom(1.25), "-": () => zoom(0.8), ArrowUp: () => tilt(0, 0.1), ArrowDown: () => tilt(0, -0.1),
    };
    canvas.addEventListener("keydown", (event) => {
      if (!KEYS[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      KEYS[event.key]();
    });
    function tilt(azimuth, elevation) {
      view.azimuth += azimuth;
      view.elevation = Math.min(Math.max(view.elevation + elevation, -1.5), 1.5);
      request();
    }
    const fingers = new Map();
    const spread = () => { const [a, b] = fingers.values(); return Math.hypot(a.x - b.x, a.y - b.y); };
    canvas.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const wide = fingers.size === 2 ? spread() : 0;
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      Object.assign(last, { x: event.clientX, y: event.clientY });
      if (wide > 0) zoom(spread() / wide);
      else tilt(-0.008 * dx, 0.008 * dy);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => {
      // A page scrolls on unless the canvas was chosen.
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(Math.exp(-0.0015 * event.deltaY));
    }, { passive: false });
    canvas.addEventListener("webglcontextlost", () => { document.querySelector(".player").hidden = true; find("instead").hidden = false; });
    new ResizeObserver(request).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", request);

    document.querySelector(".player").hidden = false;
    find("instead").hidden = true;
    stand(0);
    draw([1200, 440]);
    const picture = document.createElement("img");
    picture.src = canvas.toDataURL();
    picture.alt = `Fabric and projectile at ${animation.times[animation.opening].toFixed(1)} µs, cut open`;
    find("paper").append(picture);
    find("paper").hidden = false;
    draw();
  }

  inflated(bytesOf(find("animation-numbers").textContent.trim()))
    .then((bytes) => { start(unpack(bytes)); say("ready"); })
    .catch((error) => { say("failed"); console.error(error); });
})();
