// Triangles of shapes. Lengths are in m; shapes are centred, cylinders and capsules along z.

class Geometry {
  constructor() {
    this.positions = [];
    this.normals = [];
    this.colors = [];
    this.indices = [];
  }

  get count() { return this.indices.length; }

  vertex(position, normal) {
    this.positions.push(...position);
    this.normals.push(...normal);
    return this.positions.length / 3 - 1;
  }

  transformed(matrix) {
    const isMirror = dot(cross(matrix.slice(0, 3), matrix.slice(4, 7)), matrix.slice(8, 11)) < 0;
    const columns = [0, 4, 8].map((k) => matrix.slice(k, k + 3));
    const cofactors = [cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])];
    const sign = isMirror ? -1 : 1;
    for (let i = 0; i < this.positions.length; i += 3) {
      const p = transformPoint(matrix, this.positions.slice(i, i + 3));
      const [x, y, z] = this.normals.slice(i, i + 3);
      const n = unit([0, 1, 2].map((k) => sign * (cofactors[0][k] * x + cofactors[1][k] * y + cofactors[2][k] * z)));
      for (let k = 0; k < 3; k++) { this.positions[i + k] = p[k]; this.normals[i + k] = n[k]; }
    }
    if (isMirror) for (let i = 0; i < this.indices.length; i += 3) {
      [this.indices[i], this.indices[i + 1]] = [this.indices[i + 1], this.indices[i]];
    }
    return this;
  }

  colored(color) {
    const bytes = color.map((x) => Math.round(255 * Math.min(Math.max(x, 0), 1)));
    this.colors = [];
    for (let i = 0; i < this.positions.length; i += 3) this.colors.push(...bytes);
    return this;
  }

  append(other) {
    const first = this.positions.length / 3;
    const pushAll = (into, list, change = (x) => x) => { for (const x of list) into.push(change(x)); };
    pushAll(this.positions, other.positions);
    pushAll(this.normals, other.normals);
    pushAll(this.colors, other.colors);
    pushAll(this.indices, other.indices, (index) => index + first);
    return this;
  }

  // Replaces the lists by arrays of the graphics processor's types.
  finish() {
    this.positions = new Float32Array(this.positions);
    this.normals = new Float32Array(this.normals);
    this.colors = new Uint8Array(this.colors);
    this.indices = new Uint32Array(this.indices);
    return this;
  }

  // The corners of the bounding box.
  corners() {
    if (!this.box) {
      const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
      this.positions.forEach((x, i) => { low[i % 3] = Math.min(low[i % 3], x); high[i % 3] = Math.max(high[i % 3], x); });
      this.box = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [0, 1, 2].map((k) => (bits >> k & 1 ? high : low)[k]));
    }
    return this.box;
  }
}

// A surface of rotation about z. The profile has points [radius, z, normal along radius, normal along z] from top to bottom.
function revolved(profile, around = 40) {
  const geometry = new Geometry(), columns = around + 1;
  for (const [r, z, nr, nz] of profile) {
    for (let i = 0; i < columns; i++) {
      const angle = 2 * Math.PI * i / around, c = Math.cos(angle), s = Math.sin(angle);
      geometry.vertex([r * c, r * s, z], [nr * c, nr * s, nz]);
    }
  }
  for (let row = 0; row + 1 < profile.length; row++) {
    for (let i = 0; i < around; i++) {
      const a = row * columns + i, b = a + columns;
      geometry.indices.push(a, b, a + 1, a + 1, b, b + 1);
    }
  }
  return geometry;
}

// A quarter or more of a circle in the profile of a surface of rotation.
const arc = (centerR, centerZ, radius, from, to, steps) => Array.from({ length: steps + 1 }, (_, i) => {
  const angle = from + (to - from) * i / steps, c = Math.cos(angle), s = Math.sin(angle);
  return [centerR + radius * c, centerZ + radius * s, c, s];
});

const QUARTER = Math.PI / 2;

function cylinder(radius, length, bevel = Math.min(0.06 * radius, 0.06 * length)) {
  const half = length / 2, b = Math.min(bevel, half, radius);
  return revolved([
    [0, half, 0, 1], [radius - b, half, 0, 1], ...arc(radius - b, half - b, b, QUARTER, 0, 4),
    ...arc(radius - b, b - half, b, 0, -QUARTER, 4), [radius - b, -half, 0, -1], [0, -half, 0, -1],
  ]);
}

function cone(radius, length) {
  const slope = Math.hypot(radius, length), [nr, nz] = [length / slope, radius / slope];
  return revolved([[0, length / 2, nr, nz], [radius, -length / 2, nr, nz], [radius, -length / 2, 0, -1], [0, -length / 2, 0, -1]]);
}

// A cylinder of this length between two half spheres.
function capsule(radius, length) {
  return revolved([...arc(0, length / 2, radius, QUARTER, 0, 10), ...arc(0, -length / 2, radius, 0, -QUARTER, 10)]);
}

function ellipsoid(radii) {
  return revolved(arc(0, 0, 1, QUARTER, -QUARTER, 24)).transformed(scaling(radii));
}

// A box of these half lengths with round edges.
function roundedBox(half, radius) {
  const geometry = new Geometry(), steps = 4, r = Math.min(radius, ...half);
  // Each side of a cube as a grid whose border is bent.
  const line = [];
  for (let i = 0; i <= steps; i++) line.push([-1, Math.tan((i / steps - 1) * Math.PI / 4)]);
  for (let i = 0; i <= steps; i++) line.push([1, Math.tan(i / steps * Math.PI / 4)]);
  for (let axis = 0; axis < 3; axis++) {
    for (const side of [-1, 1]) {
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3], first = geometry.positions.length / 3;
      for (const [su, nu] of line) {
        for (const [sv, nv] of line) {
          const normal = [0, 0, 0];
          normal[axis] = side; normal[u] = nu; normal[v] = nv;
          const n = unit(normal), p = scale(n, r);
          p[axis] += side * (half[axis] - r);
          p[u] += su * (half[u] - r);
          p[v] += sv * (half[v] - r);
          geometry.vertex(p, n);
        }
      }
      const columns = line.length;
      for (let i = 0; i + 1 < columns; i++) {
        for (let j = 0; j + 1 < columns; j++) {
          const a = first + i * columns + j, b = a + columns;
          if (side > 0) geometry.indices.push(a, b, a + 1, a + 1, b, b + 1);
          else geometry.indices.push(a, a + 1, b, a + 1, b + 1, b);
        }
      }
    }
  }
  return geometry;
}

// The cosine of the angle between two triangles from which on their edge is sharp.
const SHARP = Math.cos(40 * Math.PI / 180);

// A mesh from its vertices and triangles, smooth but at sharp edges.
function meshGeometry({ vertices, faces }) {
  const geometry = new Geometry(), count = faces.length / 3;
  const at = (index) => [vertices[3 * index], vertices[3 * index + 1], vertices[3 * index + 2]];
  const normals = [], around = new Map();
  for (let f = 0; f < count; f++) {
    const [a, b, c] = [0, 1, 2].map((k) => at(faces[3 * f + k]));
    normals.push(cross(subtract(b, a), subtract(c, a)));
    for (let k = 0; k < 3; k++) {
      const vertex = faces[3 * f + k];
      if (!around.has(vertex)) around.set(vertex, []);
      around.get(vertex).push(f);
    }
  }
  const units = normals.map(unit);
  for (let f = 0; f < count; f++) {
    for (let k = 0; k < 3; k++) {
      const vertex = faces[3 * f + k];
      let sum = [0, 0, 0];
      for (const other of around.get(vertex)) if (dot(units[f], units[other]) > SHARP) sum = add(sum, normals[other]);
      geometry.indices.push(geometry.vertex(at(vertex), norm(sum) > 0 ? unit(sum) : units[f]));
    }
  }
  return geometry;
}

// The geometry of a shape of the description.
function shapeGeometry(shape, meshes) {
  if (shape.box) return roundedBox(scale(shape.box, 0.5), 0.04 * Math.min(...shape.box));
  if (shape.sphere) return ellipsoid([shape.sphere, shape.sphere, shape.sphere]);
  if (shape.ellipsoid) return ellipsoid(shape.ellipsoid);
  if (shape.cylinder) return cylinder(...shape.cylinder);
  if (shape.capsule) return capsule(...shape.capsule);
  const mesh = meshes[shape.mesh], copy = new Geometry();
  return copy.append(mesh);
}

// A mesh of the page: 16 bits for each coordinate within the bounding box, 32 for each corner of a triangle.
function decodedMesh({ low, size, vertices, faces }) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const places = Array.from(new Uint16Array(bytes(vertices)), (x, i) => low[i % 3] + size[i % 3] * x / 65535);
  return meshGeometry({ vertices: places, faces: new Uint32Array(bytes(faces)) });
}
