// Words for paths and outputs, and the units in which values are shown: those of drawings, or SI units.

const UNITS = { // unit by SI unit, and how many of it are one SI unit
  m: ["mm", 1e3], rad: ["°", 180 / Math.PI], "rad/s": ["r/min", 30 / Math.PI], "Pa s": ["mPa s", 1e3], Pa: ["MPa", 1e-6],
  "kg m2": ["kg mm²", 1e6], "m3/s": ["cm³/s", 1e6], "N/m": ["N/mm", 1e-3], "N s/m": ["N s/mm", 1e-3],
};
export const OUT_OF_PLANE = /\.(z|roll|pitch)$/;
export const SYSTEMS = ["mm, r/min, °, mPa s", "SI units"];

const WORDS = {
  x: "position x", y: "position y", vx: "velocity x", vy: "velocity y", ax: "acceleration x", ay: "acceleration y",
  omega: "angular velocity", alpha: "angular acceleration", fx: "force x", fy: "force y", ex: "eccentricity x",
  ey: "eccentricity y", inertia: "moment of inertia", youngs_modulus: "Young's modulus", poissons_ratio: "Poisson's ratio",
};

export function unitOf(si, system) { // [unit, factor]
  if (system !== SYSTEMS[1] && UNITS[si]) return UNITS[si];
  return [si === "1" ? "" : si.replace("degC", "°C").replace("s2", "s²").replace("m2", "m²").replace("m3", "m³"), 1];
}
export function labelOfOutput(name) {
  const [owner, ...rest] = name.split(".");
  return rest.length ? `${sentence(rest.map(word).join(" "))} of ${owner}` : sentence(owner);
}
export function refusal({error = "", path, problem}, controls) { // an error of the server, in the words of the field
  return controls.has(path) ? `${labelOfPath(path)}: ${problem}` : error;
}
export function labelOfPath(path) {
  const [kind, name, ...rest] = path.replace(/^sdf\./, "").split(".");
  if (!name) return sentence(word(kind));
  if (!rest.length) return kind === "parameters" ? `Parameter ${name}` : `${sentence(word(name))} (${kind})`;
  const text = rest.map(plain).join(" ").replace("pose yaw", "angle").replace("pose ", "position ").replace("com ", "centre of mass ");
  return `${sentence(text)} of ${name}`;
}
const plain = (key) => key.length > 2 ? word(key) : key;
const word = (key) => WORDS[key] ?? key.replaceAll("_", " ");
const sentence = (text) => text[0].toUpperCase() + text.slice(1);
