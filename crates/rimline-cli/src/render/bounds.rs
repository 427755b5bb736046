//! The box around positions.

/// The smallest axis-aligned box around some positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The lowest x, y and z.
    pub(crate) min: [f32; 3],
    /// The highest x, y and z.
    pub(crate) max: [f32; 3],
}

impl Bounds {
    /// The box around the finite ones of `positions`, in their space and unit. `None` if none is finite.
    pub(crate) fn of<'a>(positions: impl IntoIterator<Item = &'a [f32; 3]>) -> Option<Self> {
        positions.into_iter().filter(|position| position.iter().all(|c| c.is_finite())).fold(
            None,
            |bounds: Option<Self>, &position| {
                let Some(mut bounds) = bounds else {
                    return Some(Self { min: position, max: position });
                };
                for (axis, c) in position.into_iter().enumerate() {
                    bounds.min[axis] = bounds.min[axis].min(c);
                    bounds.max[axis] = bounds.max[axis].max(c);
                }
                Some(bounds)
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_leave_out_what_is_not_finite() {
        let positions = [[1.0, -2.0, 3.0], [f32::NAN, 9.0, 9.0], [-1.0, 4.0, 3.5]];
        let bounds = Bounds::of(&positions).expect("two are finite");
        assert_eq!((bounds.min, bounds.max), ([-1.0, -2.0, 3.0], [1.0, 4.0, 3.5]));
        assert_eq!(Bounds::of(&positions[1..2]), None);
    }
}
