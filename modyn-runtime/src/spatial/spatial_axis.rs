//! What a component of a spatial vector belongs to.

/// The axis of one of the six components of a twist or a wrench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpatialAxis {
    /// A velocity or a force along x, y or z: 0, 1 or 2.
    Linear(usize),
    /// An angular velocity or a moment about x, y or z: 0, 1 or 2.
    Angular(usize),
}

impl SpatialAxis {
    /// Returns the axis of component `component`: linear x, y, z, angular x, y, z.
    #[must_use]
    pub fn of(component: usize) -> Self {
        component.checked_sub(3).map_or(Self::Linear(component), Self::Angular)
    }

    /// Returns whether the component is an angular velocity or a moment.
    #[must_use]
    pub fn is_angular(self) -> bool {
        matches!(self, Self::Angular(_))
    }
}
