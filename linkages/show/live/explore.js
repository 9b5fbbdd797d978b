// Exploring and keeping on the live page: sweeps, sensitivities, tolerances; links, reports, notebooks. See joints.js.

export function explore(page) {
}
