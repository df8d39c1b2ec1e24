//! What a motion integrates.

/// The integrated quantities: coordinates, velocities, work and dissipated energy.
#[derive(Clone)]
pub struct State {
    pub q: Vec<f64>,
    pub qd: Vec<f64>,
    /// The work of the joint forces and the energy dissipated since the start, J.
    pub energy: [f64; 2],
}

impl State {
    /// Returns the sum of this state and `factor` times the other.
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + factor * b).collect();
        Self {
            q: add(&self.q, &other.q),
            qd: add(&self.qd, &other.qd),
            energy: [0, 1].map(|i| self.energy[i] + factor * other.energy[i]),
        }
    }
}
