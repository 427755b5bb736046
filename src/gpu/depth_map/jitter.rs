//! Jitter: by how much the boundary is moved for each bit of the stencil. The paper (section 8.3) takes rooks that do not attack
//! each other: then an edge along either axis has as many levels as there are bits.

/// For each number of bits the row of each column.
const ROOKS: [&[u32]; 8] = [
    &[0],
    &[1, 0],
    &[1, 2, 0],
    &[1, 3, 0, 2],
    &[1, 3, 0, 4, 2],
    &[2, 5, 1, 4, 0, 3],
    &[2, 5, 0, 3, 6, 1, 4],
    &[3, 7, 2, 6, 1, 5, 0, 4],
];

/// Parts of a texel across and down for each of `bits`, from 1 to 8. Each is below a half.
pub(super) fn jitters(bits: u32) -> Vec<[f64; 2]> {
    let rooks = ROOKS.get((bits as usize).saturating_sub(1)).copied().unwrap_or(&[0]);
    let part = |place: u32| (f64::from(place) + 0.5) / rooks.len() as f64 - 0.5;
    (0..).zip(rooks).map(|(column, &row)| [part(column), part(row)]).collect()
}

/// The largest part in either direction.
pub(super) fn reach(bits: u32) -> f64 {
    0.5 - 0.5 / f64::from(bits.max(1))
}

#[cfg(test)]
mod tests {
    use super::{jitters, reach};

    #[test]
    fn rooks_do_not_attack_each_other() {
        for bits in 1..=8 {
            let jitters = jitters(bits);
            assert_eq!(jitters.len(), bits as usize);
            for axis in 0..2 {
                let mut parts: Vec<_> = jitters.iter().map(|jitter| jitter[axis]).collect();
                parts.sort_by(f64::total_cmp);
                let step = 1.0 / f64::from(bits);
                assert!(parts.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() < 1e-12), "{parts:?}");
                assert!((parts[0] + reach(bits)).abs() < 1e-12 && (parts[0] + parts[parts.len() - 1]).abs() < 1e-12);
            }
        }
    }
}
