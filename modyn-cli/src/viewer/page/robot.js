// A robot as the page has it: bodies in order from the root, each with the joint to its parent; frames on bodies; shapes on
// frames. Body -1 is the world.

class Robot {
  constructor(description, meshes) {
    Object.assign(this, description);
    this.frames.forEach((frame) => { frame.matrix = fromPose(frame.pose); });
    this.bodies.forEach((body) => { body.joint.matrix = fromPose(body.joint.origin); });
    this.shapes.forEach((shape) => { shape.matrix = multiply(this.frames[shape.frame].matrix, fromPose(shape.pose)); });
    const shown = new Set(this.shapes.map((shape) => this.frames[shape.frame].body));
    this.geometries = new Map();
    const add = (body, geometry) => {
      if (!this.geometries.has(body)) this.geometries.set(body, new Geometry());
      this.geometries.get(body).append(geometry);
    };
    for (const shape of this.shapes) {
      add(this.frames[shape.frame].body, shapeGeometry(shape, meshes).transformed(shape.matrix).colored(shape.color));
    }
    this.hasShapes = shown.size > 0;
    const isBare = (body) => !this.hasShapes || body >= 0 && !shown.has(body) && this.bodies[body].mass > 0;
    standIns(this).filter(([body]) => isBare(body)).forEach(([body, geometry]) => add(body, geometry));
    this.geometries.forEach((geometry) => geometry.finish());
    this.mass = this.bodies.reduce((sum, body) => sum + body.mass, 0);
    this.size = this.extent();
  }

  // The poses of the bodies as matrices.
  poses(q) {
    const poses = [];
    for (const { parent, joint } of this.bodies) {
      const above = parent < 0 ? identity() : poses[parent];
      poses.push(multiply(above, multiply(joint.matrix, jointMotion(joint, q))));
    }
    return poses;
  }

  // The pose of something on a body.
  static on(poses, body, matrix) {
    return body < 0 ? matrix : multiply(poses[body], matrix);
  }

  centerOfMass(poses) {
    let sum = [0, 0, 0];
    this.bodies.forEach((body, i) => { sum = add(sum, scale(transformPoint(poses[i], body.center), body.mass)); });
    return this.mass > 0 ? scale(sum, 1 / this.mass) : null;
  }

  // The corners of the robot at coordinates.
  bounds(q) {
    const poses = this.poses(q), low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const see = (point) => point.forEach((x, k) => { low[k] = Math.min(low[k], x); high[k] = Math.max(high[k], x); });
    this.geometries.forEach((geometry, body) => {
      geometry.corners().forEach((corner) => see(body < 0 ? corner : transformPoint(poses[body], corner)));
    });
    poses.forEach((pose) => see(origin(pose)));
    return [low, high];
  }

  extent() {
    const [low, high] = this.bounds(this.neutral);
    return this.bodies.length ? Math.max(norm(subtract(high, low)), 1e-3) : 1;
  }

  // The coordinates between those of two instants.
  between(a, b, t) {
    const q = a.map((x, i) => x + (b[i] - x) * t);
    for (const { joint } of this.bodies) {
      const start = { spherical: joint.q, floating: joint.q + 3 }[joint.type];
      if (start === undefined) continue;
      const [from, to] = [a, b].map((list) => list.slice(start, start + 4));
      const sign = from.reduce((sum, x, i) => sum + x * to[i], 0) < 0 ? -1 : 1;
      const blend = from.map((x, i) => x + (sign * to[i] - x) * t), length = Math.hypot(...blend) || 1;
      blend.forEach((x, i) => { q[start + i] = x / length; });
    }
    return q;
  }
}

// The motion of a joint as a matrix: the pose of the body in the joint's frame.
function jointMotion(joint, q) {
  const at = (i) => joint.multiplier * q[joint.q + i] + joint.offset;
  switch (joint.type) {
    case "revolute":
    case "continuous": return rotationAbout(joint.axis, at(0));
    case "prismatic": return translation(scale(joint.axis, at(0)));
    case "universal": return multiply(rotationAbout(joint.axis, at(0)), rotationAbout(joint.second, at(1)));
    case "planar": {
      // The axes of the plane, then the rotation about its normal.
      const [x, y] = [0, 1].map((k) => [0, 3, 6].map((row) => joint.plane[row + k]));
      return multiply(translation(add(scale(x, at(0)), scale(y, at(1)))), rotationAbout(joint.axis, at(2)));
    }
    case "spherical": return fromQuaternion(q.slice(joint.q, joint.q + 4));
    case "floating": {
      const pose = fromQuaternion(q.slice(joint.q + 3, joint.q + 7));
      pose.splice(12, 3, ...q.slice(joint.q, joint.q + 3));
      return pose;
    }
    default: return identity();
  }
}

const PLASTIC = [0.86, 0.87, 0.89, 1], ACCENT = [0.16, 0.44, 0.72, 1], DARK = [0.20, 0.22, 0.25, 1];

// The density that makes the thickness of links from their masses, kg/m^3.
const DENSITY = 900;

// Shapes of links that have none: capsules from joint to joint as thick as their mass asks for, the box of the inertia where
// the robot branches, and cylinders along joint axes. Pairs of a body and a geometry.
function standIns(robot) {
  const children = new Map();
  robot.bodies.forEach((body, i) => {
    if (!children.has(body.parent)) children.set(body.parent, []);
    children.get(body.parent).push(i);
  });
  const found = [], jointRadius = robot.bodies.map(() => 0);
  // Frames that a body carries away from its origin, such as a tool or a foot.
  const tips = robot.bodies.map((_, i) => robot.frames.filter((frame) => frame.body === i && norm(frame.pose.slice(9)) > 1e-6)
    .map((frame) => frame.pose.slice(9)));
  robot.bodies.forEach((body, i) => {
    const joints = (children.get(i) || []).map((child) => robot.bodies[child].joint.origin.slice(9));
    const { mass, center } = body;
    let ends = [...joints, ...tips[i]].filter((end) => norm(end) > 1e-6);
    if (!ends.length && mass > 0 && norm(center) > 1e-6) ends = [scale(center, 2)];
    const length = ends.reduce((most, end) => Math.max(most, norm(end)), 0);
    const box = mass > 0 ? inertiaBox(body) : null;
    const isHub = box && (joints.filter((end) => norm(end) > 1e-6).length > 1 || length === 0);
    const geometry = new Geometry();
    if (isHub) {
      const half = box.half.map((x) => Math.max(x, 0.15 * Math.max(...box.half)));
      geometry.append(roundedBox(half, 0.3 * Math.min(...half)).transformed(box.matrix).colored(ACCENT));
      jointRadius[i] = 0.35 * Math.min(...half);
      for (const end of ends) if (joints.includes(end) && !isInside(end, box, half)) geometry.append(rod(box.center, end, 0.6 * jointRadius[i]).colored(DARK));
    } else if (length > 0) {
      const natural = mass > 0 ? Math.sqrt(mass / (DENSITY * Math.PI * length)) : 0.03 * length;
      const radius = Math.min(Math.max(natural, 0.04 * length), 0.2 * length);
      jointRadius[i] = radius;
      for (const end of ends) geometry.append(rod([0, 0, 0], end, radius).colored(PLASTIC));
    }
    if (geometry.count) found.push([i, geometry]);
  });
  // The joints themselves.
  robot.bodies.forEach((body, i) => {
    const { joint, parent } = body;
    const radii = [jointRadius[i], parent >= 0 ? jointRadius[parent] : 0].filter((radius) => radius > 0);
    const radius = radii.length ? Math.min(...radii) : 0;
    if (!(radius > 0) || joint.type === "floating" || joint.type === "planar") return;
    const [x, y, z] = axesAlong(joint.axis);
    const geometry = joint.type === "prismatic" ? roundedBox([0.9 * radius, 0.9 * radius, 1.3 * radius], 0.15 * radius)
      : joint.type === "revolute" || joint.type === "continuous" ? cylinder(1.15 * radius, 2.4 * radius, 0.12 * radius)
        : ellipsoid([1.2 * radius, 1.2 * radius, 1.2 * radius]);
    found.push([i, geometry.transformed(fromAxes(x, y, z, [0, 0, 0])).colored(DARK)]);
  });
  // A base for joints on the world: the box of its inertia, if several joints are on it, or columns.
  const joints = (children.get(-1) || []).map((child) => robot.bodies[child].joint.origin.slice(9));
  if (robot.base.mass > 0 && joints.length > 1) {
    const box = inertiaBox(robot.base), geometry = new Geometry();
    const half = box.half.map((x) => Math.max(x, 0.15 * Math.max(...box.half))), radius = 0.3 * Math.min(...half);
    geometry.append(roundedBox(half, radius).transformed(box.matrix).colored(ACCENT));
    for (const end of joints) if (!isInside(end, box, half)) geometry.append(rod(box.center, end, 0.7 * radius).colored(DARK));
    found.push([-1, geometry]);
    return found;
  }
  for (const child of children.get(-1) || []) {
    const { joint } = robot.bodies[child];
    if (joint.type === "floating" || joint.type === "planar") continue;
    const at = joint.origin.slice(9), radius = 1.3 * (jointRadius[child] || 0.02);
    if (norm(at) > 2 * radius && at[2] > 0) found.push([-1, rod([at[0], at[1], 0], at, radius).colored(DARK)]);
  }
  return found;
}

function isInside(point, box, half) {
  const away = subtract(point, box.center);
  return box.axes.every((axis, k) => Math.abs(dot(axis, away)) < half[k]);
}

// The solid box with a body's mass and inertia: its centre, axes and half lengths.
function inertiaBox(body) {
  const { axes, moments } = principalAxes(body.inertia), sum = moments.reduce((a, b) => a + b, 0);
  const half = moments.map((moment) => Math.sqrt(Math.max(1.5 * (sum - 2 * moment) / body.mass, 0)));
  return { center: body.center, axes, half, matrix: fromAxes(...axes, body.center) };
}

// A capsule between two points.
function rod(from, to, radius) {
  const along = subtract(to, from);
  return capsule(radius, norm(along)).transformed(fromAxes(...axesAlong(along), scale(add(from, to), 0.5)));
}
