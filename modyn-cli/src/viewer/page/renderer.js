// Draws geometries with WebGL2: a light with a shadow map, the sky's light, and a ground with a grid. z points upwards.

const SHADOW_SIZE = 2048;

const COMMON = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
`;

const BODY_VERTEX = `${COMMON}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
uniform mat4 viewProjection, model, light;
uniform float stretch;
out vec3 worldPosition, worldNormal;
out vec4 lightPosition, surface;
void main() {
  // Capsules of any length are one geometry, whose halves move apart.
  vec3 stretched = position + vec3(0, 0, position.z > 0.0 ? stretch : -stretch);
  vec4 world = model * vec4(stretched, 1);
  mat3 m = mat3(model);
  worldNormal = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal;
  worldPosition = world.xyz;
  lightPosition = light * world;
  surface = color;
  gl_Position = viewProjection * world;
}`;

const SHADE = `
uniform sampler2DShadow shadow;
uniform float texel;
float lit(vec4 p, float bias, float spread) {
  vec3 q = p.xyz * 0.5 + 0.5;
  if (any(lessThan(q, vec3(0))) || any(greaterThan(q, vec3(1)))) return 1.0;
  float sum = 0.0;
  // Samples on a spiral, turned from pixel to pixel, make the penumbra smooth.
  float turn = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  for (int i = 0; i < 16; i++) {
    float r = sqrt((float(i) + 0.5) / 16.0) * spread, a = turn + 2.3999632 * float(i);
    sum += texture(shadow, vec3(q.xy + r * texel * vec2(cos(a), sin(a)), q.z - bias));
  }
  return sum / 16.0;
}
vec3 encoded(vec3 linear) {
  // The filmic curve of Narkowicz (2016), then sRGB.
  vec3 x = linear * 0.72;
  x = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}
`;

const BODY_FRAGMENT = `${COMMON}
in vec3 worldPosition, worldNormal;
in vec4 lightPosition, surface;
uniform vec3 eye, toLight;
uniform vec4 tint;
uniform float flatness;
out vec4 color;
${SHADE}
void main() {
  vec3 n = normalize(worldNormal), v = normalize(eye - worldPosition);
  if (dot(n, v) < 0.0 && !gl_FrontFacing) n = -n;
  vec3 base = pow(surface.rgb, vec3(2.2)) * tint.rgb;
  vec3 sky = mix(vec3(0.34, 0.33, 0.32), vec3(0.80, 0.86, 0.95), 0.5 + 0.5 * n.z);
  float cosine = max(dot(n, toLight), 0.0);
  float visible = cosine > 0.0 ? lit(lightPosition, 0.002 + 0.006 * (1.0 - cosine), 2.5) : 0.0;
  vec3 h = normalize(toLight + v);
  float gloss = pow(max(dot(n, h), 0.0), 60.0) * 0.55 * visible;
  float edge = pow(1.0 - max(dot(n, v), 0.0), 4.0) * 0.22;
  float fill = max(dot(n, normalize(vec3(-toLight.y, toLight.x, 0.4))), 0.0) * 0.25;
  vec3 shaded = base * (0.62 * sky + 2.1 * cosine * visible * vec3(1.0, 0.97, 0.92) + fill) + vec3(gloss) + sky * edge;
  color = vec4(mix(encoded(shaded), surface.rgb * tint.rgb, flatness), surface.a * tint.a);
}`;

const GROUND_VERTEX = `${COMMON}
layout(location = 0) in vec3 position;
uniform mat4 viewProjection, light;
uniform vec3 middle;
uniform float extent;
out vec3 worldPosition;
out vec4 lightPosition;
void main() {
  worldPosition = middle + extent * position;
  lightPosition = light * vec4(worldPosition, 1);
  gl_Position = viewProjection * vec4(worldPosition, 1);
}`;

const GROUND_FRAGMENT = `${COMMON}
in vec3 worldPosition;
in vec4 lightPosition;
uniform vec3 eye, middle, paper, ink;
uniform float square, reach, grid, shade;
out vec4 color;
${SHADE}
float lines(vec2 at, float width) {
  vec2 w = fwidth(at), d = abs(fract(at - 0.5) - 0.5);
  vec2 l = 1.0 - smoothstep(vec2(width), vec2(width) + 1.2, d / max(w, 1e-6));
  // Lines closer than pixels are a mean.
  l *= 1.0 - smoothstep(0.25, 0.7, w);
  return max(l.x, l.y);
}
void main() {
  vec2 at = worldPosition.xy / square;
  float fine = lines(at, 0.1), coarse = lines(at / 5.0, 0.35);
  float tile = mod(floor(at.x / 5.0) + floor(at.y / 5.0), 2.0);
  vec2 w = fwidth(at / 5.0);
  tile = mix(tile, 0.5, smoothstep(0.2, 0.8, max(w.x, w.y)));
  vec3 ground = mix(paper, ink, grid * (0.035 * tile + 0.10 * fine + 0.20 * coarse));
  float far = distance(worldPosition.xy, middle.xy) / reach;
  float dark = (1.0 - lit(lightPosition, 0.0008, 5.0)) * 0.42 * shade;
  float fade = 1.0 - smoothstep(0.35, 1.0, far);
  // From below, the ground is seen through.
  float above = eye.z > worldPosition.z ? 1.0 : 0.25;
  color = vec4(mix(paper, ground * (1.0 - dark), fade), fade * above);
}`;

const DEPTH_FRAGMENT = `${COMMON}
void main() {}`;

const SKY_VERTEX = `${COMMON}
out vec2 at;
void main() {
  at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
  gl_Position = vec4(at * 2.0 - 1.0, 1.0, 1.0);
}`;

const SKY_FRAGMENT = `${COMMON}
in vec2 at;
uniform vec3 paper, zenith;
out vec4 color;
void main() { color = vec4(mix(paper, zenith, smoothstep(0.45, 1.1, at.y)), 1); }`;

class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL2, which draws the robot");
    this.gl = gl;
    this.body = this.program(BODY_VERTEX, BODY_FRAGMENT);
    this.depth = this.program(BODY_VERTEX, DEPTH_FRAGMENT);
    this.ground = this.program(GROUND_VERTEX, GROUND_FRAGMENT);
    this.sky = this.program(SKY_VERTEX, SKY_FRAGMENT);
    this.empty = gl.createVertexArray();
    const plane = new Geometry();
    [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]].forEach((corner) => plane.vertex(corner, [0, 0, 1]));
    plane.indices.push(0, 1, 2, 0, 2, 3);
    this.plane = plane.colored([1, 1, 1, 1]).finish();
    this.shadow = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    for (const [name, value] of [["MIN_FILTER", "LINEAR"], ["MAG_FILTER", "LINEAR"], ["WRAP_S", "CLAMP_TO_EDGE"],
      ["WRAP_T", "CLAMP_TO_EDGE"], ["COMPARE_MODE", "COMPARE_REF_TO_TEXTURE"]]) {
      gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl[value]);
    }
    this.shadowTarget = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadow, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.buffers = new Map();
  }

  program(vertex, fragment) {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
        throw new Error(gl.getShaderInfoLog(shader));
      }
    }
    gl.linkProgram(program);
    const places = new Map();
    // Sets a uniform by its name: a number, a vector or a matrix.
    const set = (name, value) => {
      if (!places.has(name)) places.set(name, gl.getUniformLocation(program, name));
      const place = places.get(name);
      if (typeof value === "number") gl.uniform1f(place, value);
      else if (value.length === 3) gl.uniform3fv(place, value);
      else if (value.length === 4) gl.uniform4fv(place, value);
      else gl.uniformMatrix4fv(place, false, value);
    };
    return { program, set };
  }

  // The geometry's vertex array on the graphics processor.
  array(geometry) {
    if (this.buffers.has(geometry)) return this.buffers.get(geometry);
    const { gl } = this, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    [[geometry.positions, 3, gl.FLOAT, false], [geometry.normals, 3, gl.FLOAT, false], [geometry.colors, 4, gl.UNSIGNED_BYTE, true]]
      .forEach(([data, size, type, isScaled], place) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, size, type, isScaled, 0, 0);
      });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, geometry.indices, gl.STATIC_DRAW);
    this.buffers.set(geometry, array);
    return array;
  }

  // Draws items: { geometry, matrix, tint, stretch, flatness, isOverlay }.
  //
  // The scene has the camera (eye, target), the size and the middle of everything, the height and the squares of the ground
  // (or no ground), and colours.
  draw(items, scene) {
    const { gl } = this, { width, height } = this.canvas;
    const solid = items.filter((item) => !item.isOverlay && !(item.tint && item.tint[3] < 1));
    const clear = items.filter((item) => !item.isOverlay && item.tint && item.tint[3] < 1);
    const overlay = items.filter((item) => item.isOverlay);
    const toLight = unit([0.45, -0.55, 1.1]), half = 0.75 * scene.size;
    const light = multiply(orthographic(half, 2 * scene.size),
      lookAt(add(scene.middle, toLight), scene.middle, [0, 1, 0]));

    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    if (scene.shadows) {
      gl.useProgram(this.depth.program);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1.5, 2);
      this.drawItems(this.depth, solid, light, light);
      gl.disable(gl.POLYGON_OFFSET_FILL);
    }

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.clearColor(...scene.paper, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.depthMask(false);
    gl.useProgram(this.sky.program);
    this.sky.set("paper", scene.paper);
    this.sky.set("zenith", scene.zenith);
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.depthMask(true);
    const distance = norm(subtract(scene.eye, scene.target));
    const far = 20 * scene.size + 4 * distance;
    const viewProjection = multiply(perspective(scene.fieldOfView, width / height, Math.max(0.01 * distance, 1e-4 * far), far),
      lookAt(scene.eye, scene.target, [0, 0, 1]));
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.useProgram(this.body.program);
    const common = ({ set }) => { set("eye", scene.eye); set("toLight", toLight); set("texel", 1 / SHADOW_SIZE); };
    common(this.body);
    this.drawItems(this.body, solid, viewProjection, light);
    gl.enable(gl.BLEND);
    if (scene.ground !== null) {
      gl.useProgram(this.ground.program);
      common(this.ground);
      const middle = [scene.middle[0], scene.middle[1], scene.ground];
      for (const [name, value] of Object.entries({
        viewProjection, light, middle, extent: 12 * scene.size, reach: 6 * scene.size, square: scene.square, paper: scene.paper,
        ink: scene.ink, grid: scene.grid ? 1 : 0, shade: scene.shadows ? 1 : 0,
      })) this.ground.set(name, value);
      gl.bindVertexArray(this.array(this.plane));
      gl.drawElements(gl.TRIANGLES, 6, gl.UNSIGNED_INT, 0);
      gl.useProgram(this.body.program);
    }
    gl.depthMask(false);
    gl.enable(gl.CULL_FACE);
    this.drawItems(this.body, clear, viewProjection, light);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.drawItems(this.body, overlay, viewProjection, light);
    gl.disable(gl.BLEND);
  }

  drawItems({ set }, items, viewProjection, light) {
    const { gl } = this;
    set("viewProjection", viewProjection);
    set("light", light);
    for (const { geometry, matrix, tint = [1, 1, 1, 1], stretch = 0, flatness = 0 } of items) {
      set("model", matrix);
      set("tint", tint);
      set("stretch", stretch);
      set("flatness", flatness);
      gl.bindVertexArray(this.array(geometry));
      gl.drawElements(gl.TRIANGLES, geometry.count, gl.UNSIGNED_INT, 0);
    }
  }
}
