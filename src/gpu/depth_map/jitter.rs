//! Jitter: the offset of the boundary for each bit of the stencil. Offsets are the squares of rooks that do not attack each
//! other (section 8.3 of the paper), so an edge along either axis has as many levels as there are bits.

/// The row of the rook in each column, for 1 to 8 bits.
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

/// The offset for each of `bits`, from 1 to 8: across and down, in texels. Offsets are below a half.
pub(super) fn jitters(bits: u32) -> Vec<[f64; 2]> {
    let rooks = ROOKS.get((bits as usize).saturating_sub(1)).copied().unwrap_or(&[0]);
    let offset = |index: u32| (f64::from(index) + 0.5) / rooks.len() as f64 - 0.5;
    (0..).zip(rooks).map(|(column, &row)| [offset(column), offset(row)]).collect()
}

/// The largest offset in either direction, in texels.
pub(super) fn max_jitter(bits: u32) -> f64 {
    0.5 - 0.5 / f64::from(bits.max(1))
}

#[cfg(test)]
mod tests {
    use super::{jitters, max_jitter};

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
                assert!(
                    (parts[0] + max_jitter(bits)).abs() < 1e-12 && (parts[0] + parts[parts.len() - 1]).abs() < 1e-12
                );
            }
        }
    }
}
