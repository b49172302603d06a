"use strict";
/* The part, the path and the tool in WebGL. Millimetres, z up; matrices column by column. */
const viewer = (() => {
  const FIELD = 35 * Math.PI / 180;
  const STOP = 13; /* numbers of a stop: tip, axis, P, Q, tilt */

  /* ---- vectors and matrices ---- */
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const mad = (a, b, k) => [a[0] + b[0] * k, a[1] + b[1] * k, a[2] + b[2] * k];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const n = Math.hypot(...a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };
  const mix = (a, b, t) => mad(a, sub(b, a), t);

  function times(a, b) {
    const m = new Float32Array(16);
    for (let c = 0; c < 4; c++)
      for (let r = 0; r < 4; r++)
        m[4 * c + r] = a[r] * b[4 * c] + a[4 + r] * b[4 * c + 1] + a[8 + r] * b[4 * c + 2] + a[12 + r] * b[4 * c + 3];
    return m;
  }

  function perspective(aspect, near, far) {
    const f = 1 / Math.tan(FIELD / 2), d = near - far;
    return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) / d, -1, 0, 0, 2 * near * far / d, 0]);
  }

  function lookAt(eye, target, up) {
    const back = unit(sub(eye, target)), right = unit(cross(up, back)), over = cross(back, right);
    return new Float32Array([right[0], over[0], back[0], 0, right[1], over[1], back[1], 0, right[2], over[2], back[2], 0,
      -dot(right, eye), -dot(over, eye), -dot(back, eye), 1]);
  }

  /* Tip at the origin, axis +z, to where the tool stands. */
  function pose(tip, axis) {
    const side = Math.hypot(axis[0], axis[1]);
    const x = side > 1e-9 ? unit(cross([axis[1] / side, -axis[0] / side, 0], axis)) : [1, 0, 0];
    const y = cross(axis, x);
    return new Float32Array([...x, 0, ...y, 0, ...axis, 0, ...tip, 1]);
  }
  const IDENTITY = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

  /* ---- shaders ---- */
  const SOLID_VERTEX = `#version 300 es
    in vec3 position; in vec3 normal;
    uniform mat4 view, model; uniform vec4 rectangle;
    out vec3 n, at; out vec2 place;
    void main() {
      vec4 world = model * vec4(position, 1.0);
      n = mat3(model) * normal; at = world.xyz;
      place = (world.xy - rectangle.xy) * rectangle.zw;
      gl_Position = view * world;
    }`;
  const SOLID_FRAGMENT = `#version 300 es
    precision highp float;
    in vec3 n, at; in vec2 place;
    uniform vec4 colour; uniform vec3 eye; uniform sampler2D map; uniform float mapped;
    out vec4 pixel;
    void main() {
      vec3 m = normalize(n), look = normalize(eye - at);
      vec3 base = colour.rgb;
      if (mapped > 0.5 && m.z > 0.02 && all(greaterThan(place, vec2(0.0))) && all(lessThan(place, vec2(1.0)))) {
        vec4 c = texture(map, place);
        base = mix(base, c.rgb, c.a);
      }
      if (dot(m, look) < 0.0) m = -m;
      float lit = 0.42 + 0.34 * max(dot(m, look), 0.0) + 0.34 * max(dot(m, normalize(vec3(-0.48, 0.56, 0.9))), 0.0);
      float shine = 0.10 * pow(max(dot(reflect(-look, m), normalize(vec3(-0.3, 0.4, 1.0))), 0.0), 24.0);
      pixel = vec4(base * lit + shine, 1.0) * colour.a;
    }`;
  const MARK_VERTEX = `#version 300 es
    in vec3 position; in vec4 tint;
    uniform mat4 view; uniform float size, lift;
    out vec4 shade;
    void main() {
      gl_Position = view * vec4(position, 1.0);
      gl_Position.z -= lift * gl_Position.w;
      gl_PointSize = size; shade = tint;
    }`;
  const MARK_FRAGMENT = `#version 300 es
    precision highp float;
    in vec4 shade; uniform float round;
    out vec4 pixel;
    void main() {
      if (round > 0.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
      pixel = vec4(shade.rgb, 1.0) * shade.a;
    }`;

  function program(gl, vertex, fragment) {
    const p = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const s = gl.createShader(kind);
      gl.shaderSource(s, text);
      gl.compileShader(s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
      gl.attachShader(p, s);
    }
    gl.bindAttribLocation(p, 0, "position");
    gl.bindAttribLocation(p, 1, "normal");
    gl.bindAttribLocation(p, 1, "tint");
    gl.linkProgram(p);
    if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
    const at = {};
    for (let i = 0; i < gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS); i++) {
      const name = gl.getActiveUniform(p, i).name;
      at[name] = gl.getUniformLocation(p, name);
    }
    return { p, at };
  }

  function buffer(gl, target, data) {
    const b = gl.createBuffer();
    gl.bindBuffer(target, b);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return b;
  }

  /* Points, normals as bytes, indices. */
  function solid(gl, mesh) {
    const v = gl.createVertexArray();
    gl.bindVertexArray(v);
    buffer(gl, gl.ARRAY_BUFFER, mesh.points);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    buffer(gl, gl.ARRAY_BUFFER, mesh.normals);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.BYTE, true, 4, 0);
    buffer(gl, gl.ELEMENT_ARRAY_BUFFER, mesh.indices);
    gl.bindVertexArray(null);
    return { v, count: mesh.indices.length };
  }

  /* Points or ends of lines, each with a colour. */
  function marks(gl, points, tints) {
    const v = gl.createVertexArray();
    gl.bindVertexArray(v);
    buffer(gl, gl.ARRAY_BUFFER, new Float32Array(points));
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    buffer(gl, gl.ARRAY_BUFFER, new Uint8Array(tints));
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 4, gl.UNSIGNED_BYTE, true, 0, 0);
    gl.bindVertexArray(null);
    return { v, count: points.length / 3 };
  }

  /* ---- the viewer ---- */
  class Viewer {
    /* model: { box: [low, high], mesh, solids, stops: Float32Array, names: Uint32Array, map or
     * null, reach: of the cutter, height: of the tool, upright: tools came down along z
     * and leant by their tilt }. Throws where there is no WebGL 2. */
    constructor(canvas, model) {
      this.canvas = canvas;
      this.model = model;
      this.gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
      if (!this.gl) throw new Error("WebGL 2 is missing");
      this.show = { tool: true, contacts: true, path: true, axes: false, map: false };
      this.at = 0; /* position, with a fraction between two */
      this.dark = false;
      this.drawn = 0; /* frames */
      this.onDraw = () => {};
      const [low, high] = model.box;
      this.middle = mix(low, high, 0.5);
      this.radius = Math.max(0.5 * Math.hypot(...sub(high, low)), model.reach);
      this.look("corner");
      this.prepare();
      this.listen();
      new ResizeObserver(() => this.invalidate()).observe(canvas);
    }

    stop(i) {
      const v = this.model.stops.subarray(STOP * i, STOP * i + STOP);
      return { tip: [...v.slice(0, 3)], axis: [...v.slice(3, 6)], p: [...v.slice(6, 9)], q: [...v.slice(9, 12)], tilt: v[12],
        status: this.model.names[4 * i + 2], linked: this.model.names[4 * i + 3] === 1 };
    }

    prepare() {
      const gl = this.gl, m = this.model;
      this.solids = program(gl, SOLID_VERTEX, SOLID_FRAGMENT);
      this.markers = program(gl, MARK_VERTEX, MARK_FRAGMENT);
      this.part = solid(gl, m.mesh);
      this.tool = m.solids.map((s) => ({ kind: s.kind, ...solid(gl, s) }));
      this.texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      const map = m.map || { width: 1, height: 1, rgba: new Uint8Array(4) };
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, map.width, map.height, 0, gl.RGBA, gl.UNSIGNED_BYTE, map.rgba);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
      this.colour();
    }

    /* What has the theme's colours. */
    colour() {
      const gl = this.gl, n = this.model.names.length / 4, dark = this.dark;
      const P = dark ? [86, 180, 233, 255] : [0, 114, 178, 255], Q = dark ? [255, 157, 87, 255] : [213, 94, 0, 255];
      const one = dark ? [255, 255, 255, 255] : [20, 20, 24, 255], line = dark ? [200, 210, 220, 150] : [40, 50, 60, 130];
      const way = dark ? [240, 240, 245, 220] : [25, 30, 38, 220], both = dark ? [230, 140, 200, 255] : [139, 28, 107, 255];
      const dots = [[], []], joins = [[], []], path = [[], []], axes = [[], []];
      const put = (list, point, tint) => { list[0].push(...point); list[1].push(...tint); };
      for (let i = 0; i < n; i++) {
        const s = this.stop(i);
        if (!Number.isFinite(s.tip[0]) || s.status === 3) continue;
        const pair = Number.isFinite(s.q[0]) && s.status !== 1;
        put(dots, s.p, s.status === 1 ? both : pair ? P : one);
        if (pair) { put(dots, s.q, Q); put(joins, s.p, line); put(joins, s.q, line); }
        put(axes, s.tip, line);
        put(axes, mad(s.tip, s.axis, this.model.reach), line);
        if (s.linked && i > 0) { put(path, this.stop(i - 1).tip, way); put(path, s.tip, way); }
      }
      this.tints = { P, Q, one, way, both, line };
      this.dots = marks(gl, ...dots);
      this.joins = marks(gl, ...joins);
      this.path = marks(gl, ...path);
      this.axes = marks(gl, ...axes);
    }

    setTheme(dark) {
      if (dark !== this.dark) { this.dark = dark; this.colour(); }
      this.invalidate();
    }

    /* ---- camera ---- */
    look(from) {
      const at = { corner: [-0.6, 0.62], above: [-Math.PI / 2, Math.PI / 2 - 1e-3], front: [-Math.PI / 2, 0.08], side: [0, 0.08] }[from];
      if (from === "tool") {
        const s = this.here();
        this.target = mad(s.tip, s.axis, 0.6 * this.model.reach);
        this.distance = 2.6 * this.model.reach / Math.sin(FIELD / 2);
        this.pitch = 0.35;
        if (Number.isFinite(s.q[0]) && Math.hypot(s.q[0] - s.p[0], s.q[1] - s.p[1]) > 1e-6)
          this.yaw = Math.atan2(s.q[1] - s.p[1], s.q[0] - s.p[0]) - Math.PI / 2; /* P left, Q right */
      } else {
        [this.yaw, this.pitch] = at;
        this.fit();
      }
      this.invalidate();
    }

    /* As near as shows all of the part, and the tool wherever it stands on it. */
    fit() {
      const [low, high] = this.model.box, reach = this.model.reach, up = 0.7 * this.model.height;
      this.target = mad(this.middle, [0, 0, 1], 0.3 * up);
      this.distance = 1;
      const back = unit(sub(this.eye(), this.target)), right = unit(cross([0, 0, 1], back)), over = cross(back, right);
      const t = Math.tan(FIELD / 2), wide = t * this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
      let least = 0;
      for (let k = 0; k < 8; k++) {
        const corner = [k & 1 ? high[0] + reach : low[0] - reach, k & 2 ? high[1] + reach : low[1] - reach, k & 4 ? high[2] + up : low[2]];
        const c = sub(corner, this.target);
        least = Math.max(least, Math.abs(dot(c, right)) / wide + dot(c, back), Math.abs(dot(c, over)) / t + dot(c, back));
      }
      this.distance = 1.04 * least;
    }

    eye() {
      const c = Math.cos(this.pitch);
      return mad(this.target, [c * Math.cos(this.yaw), c * Math.sin(this.yaw), Math.sin(this.pitch)], this.distance);
    }

    turn(dx, dy) {
      this.yaw -= dx;
      this.pitch = Math.min(Math.PI / 2 - 1e-3, Math.max(-Math.PI / 2 + 1e-3, this.pitch + dy));
      this.invalidate();
    }

    /* dx, dy: pixels. */
    shift(dx, dy) {
      const k = 2 * this.distance * Math.tan(FIELD / 2) / this.canvas.clientHeight;
      const back = unit(sub(this.eye(), this.target)), right = unit(cross([0, 0, 1], back)), over = cross(back, right);
      this.target = mad(mad(this.target, right, -dx * k), over, dy * k);
      this.invalidate();
    }

    zoom(by) {
      this.distance = Math.min(20 * this.radius, Math.max(0.02 * this.radius, this.distance * by));
      this.invalidate();
    }

    listen() {
      const c = this.canvas, down = new Map();
      c.addEventListener("contextmenu", (e) => e.preventDefault());
      c.addEventListener("wheel", (e) => { e.preventDefault(); this.zoom(Math.exp(Math.sign(e.deltaY) * 0.12)); }, { passive: false });
      c.addEventListener("pointerdown", (e) => {
        c.setPointerCapture(e.pointerId);
        down.set(e.pointerId, [e.clientX, e.clientY]);
      });
      for (const end of ["pointerup", "pointercancel"]) c.addEventListener(end, (e) => down.delete(e.pointerId));
      c.addEventListener("pointermove", (e) => {
        const last = down.get(e.pointerId);
        if (!last) return;
        const dx = e.clientX - last[0], dy = e.clientY - last[1];
        if (down.size === 2) {
          const other = [...down].find(([id]) => id !== e.pointerId)[1];
          const before = Math.hypot(last[0] - other[0], last[1] - other[1]);
          const now = Math.hypot(e.clientX - other[0], e.clientY - other[1]);
          if (before > 0 && now > 0) this.zoom(before / now);
          this.shift(dx / 2, dy / 2);
        } else if (e.buttons & 6 || e.shiftKey) {
          this.shift(dx, dy);
        } else {
          this.turn(dx * 0.008, dy * 0.008);
        }
        down.set(e.pointerId, [e.clientX, e.clientY]);
      });
    }

    /* True when the key was one of the view's. */
    key(name) {
      const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
      if (turns[name]) this.turn(...turns[name]);
      else if (name === "+" || name === "=") this.zoom(0.85);
      else if (name === "-") this.zoom(1 / 0.85);
      else return false;
      return true;
    }

    /* ---- drawing ---- */

    /* The tool now: at a stop, or between two that are linked. */
    here() {
      const i = Math.floor(this.at), t = this.at - i, a = this.stop(i);
      if (t === 0 || i + 1 >= this.model.names.length / 4) return a;
      const b = this.stop(i + 1);
      if (!b.linked) return a;
      return { ...a, tip: mix(a.tip, b.tip, t), axis: unit(mix(a.axis, b.axis, t)) };
    }

    invalidate() {
      if (this.pending) return;
      this.pending = true;
      requestAnimationFrame(() => { this.pending = false; this.draw(); });
    }

    /* Pixels (CSS) of a place, or null behind the eye. */
    project(p) {
      const m = this.view, w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
      if (!(w > 0)) return null;
      const x = (m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]) / w, y = (m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]) / w;
      return [(x + 1) / 2 * this.canvas.clientWidth, (1 - y) / 2 * this.canvas.clientHeight];
    }

    drawSolid(s, model, rgb, alpha, mapped) {
      const gl = this.gl, at = this.solids.at, map = this.model.map;
      gl.useProgram(this.solids.p);
      gl.uniformMatrix4fv(at.view, false, this.view);
      gl.uniformMatrix4fv(at.model, false, model);
      gl.uniform4f(at.colour, ...rgb, alpha);
      gl.uniform3f(at.eye, ...this.eye());
      gl.uniform1f(at.mapped, mapped ? 1 : 0);
      const half = map ? map.cell / 2 : 0;
      if (map) gl.uniform4f(at.rectangle, map.x - half, map.y - half, 1 / (map.width * map.cell), 1 / (map.height * map.cell));
      else gl.uniform4f(at.rectangle, 0, 0, 0, 0);
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.bindVertexArray(s.v);
      gl.drawElements(gl.TRIANGLES, s.count, gl.UNSIGNED_INT, 0);
    }

    drawMarks(s, mode, size, lift) {
      const gl = this.gl, at = this.markers.at;
      if (s.count === 0) return;
      gl.useProgram(this.markers.p);
      gl.uniformMatrix4fv(at.view, false, this.view);
      gl.uniform1f(at.size, size);
      gl.uniform1f(at.lift, lift);
      gl.uniform1f(at.round, mode === gl.POINTS ? 1 : 0);
      gl.bindVertexArray(s.v);
      gl.drawArrays(mode, 0, s.count);
    }

    /* The nearest face alone, see-through. */
    drawTool(here) {
      const gl = this.gl, model = pose(here.tip, here.axis);
      const rgb = { insert: [0.92, 0.70, 0.20], shank: [0.66, 0.69, 0.74], holder: [0.42, 0.46, 0.52], body: [0.66, 0.69, 0.74] };
      gl.colorMask(false, false, false, false);
      for (const s of this.tool) this.drawSolid(s, model, [0, 0, 0], 1, false);
      gl.colorMask(true, true, true, true);
      gl.depthFunc(gl.LEQUAL);
      for (const s of this.tool) this.drawSolid(s, model, rgb[s.kind], s.kind === "insert" ? 0.72 : 0.42, false);
      gl.depthFunc(gl.LESS);
    }

    /* P, Q, the line between them and the axis, over everything. */
    drawHere(here) {
      const gl = this.gl, top = mad(here.tip, here.axis, this.model.height * 1.08), t = this.tints;
      const pair = Number.isFinite(here.q[0]) && here.status !== 1;
      const lines = [[], []], dots = [[], []], put = (list, point, tint) => { list[0].push(...point); list[1].push(...tint); };
      put(lines, here.tip, t.way);
      put(lines, top, t.way);
      if (this.model.upright) { /* the axis as the tool came down */
        put(lines, here.tip, t.line);
        put(lines, mad(here.tip, [0, 0, 1], this.model.height * 1.08), t.line);
      }
      if (pair) { put(lines, here.p, t.way); put(lines, here.q, t.way); put(dots, here.q, t.Q); }
      if (Number.isFinite(here.p[0])) put(dots, here.p, here.status === 1 ? t.both : pair ? t.P : t.one);
      gl.disable(gl.DEPTH_TEST);
      for (const [list, mode, size] of [[lines, gl.LINES, 1], [dots, gl.POINTS, 13 * this.scale]]) {
        const m = marks(gl, ...list);
        this.drawMarks(m, mode, size, 0);
        gl.deleteVertexArray(m.v);
      }
      gl.enable(gl.DEPTH_TEST);
    }

    draw() {
      const gl = this.gl, c = this.canvas;
      this.scale = Math.min(window.devicePixelRatio || 1, 2);
      const width = Math.max(1, Math.round(c.clientWidth * this.scale)), height = Math.max(1, Math.round(c.clientHeight * this.scale));
      if (c.width !== width || c.height !== height) { c.width = width; c.height = height; }
      const eye = this.eye(), reach = 3 * this.radius + this.model.height;
      const far = this.distance + reach, near = Math.max(this.distance - reach, far * 1e-3);
      this.view = times(perspective(width / height, near, far), lookAt(eye, this.target, [0, 0, 1]));
      gl.viewport(0, 0, width, height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      this.drawSolid(this.part, IDENTITY, this.dark ? [0.62, 0.66, 0.70] : [0.66, 0.71, 0.77], 1, this.show.map);
      const lift = 0.0015;
      if (this.show.axes) this.drawMarks(this.axes, gl.LINES, 1, lift);
      if (this.show.path) this.drawMarks(this.path, gl.LINES, 1, lift);
      if (this.show.contacts) {
        const room = 2 * this.radius / Math.sqrt(this.model.names.length / 4) / this.distance * c.clientHeight;
        this.drawMarks(this.joins, gl.LINES, 1, lift);
        this.drawMarks(this.dots, gl.POINTS, Math.min(7, Math.max(3.2, 0.16 * room)) * this.scale, 1.3 * lift);
      }
      const here = this.here();
      if (this.show.tool && Number.isFinite(here.tip[0])) {
        this.drawTool(here);
        this.drawHere(here);
      }
      gl.bindVertexArray(null);
      this.drawn++;
      this.onDraw(here);
    }
  }

  return { Viewer, STOP };
})();
