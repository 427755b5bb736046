//! The least number of sides among all choices, where these are too many to try: by a flow on a table, which is made by
//! asking for the sides without each face and without each two.

use std::collections::VecDeque;

/// The least of `cost` over all sets of `count` faces. Two faces must cost no more together than each alone, less nothing.
pub(crate) fn least(count: usize, cost: impl Fn(&[usize]) -> i64) -> i64 {
    let none = cost(&[]);
    let alone: Vec<i64> = (0..count).map(|face| cost(&[face]) - none).collect();
    // left[a][b] is what may still flow from a to b. The two last places are source and sink. Left out is the side of
    // the sink.
    let (source, sink) = (count, count + 1);
    let mut left = vec![vec![0_i64; count + 2]; count + 2];
    let mut linear = alone.clone();
    for a in 0..count {
        for b in a + 1..count {
            let spared = alone[a] + alone[b] + none - cost(&[a, b]);
            assert!(spared >= 0, "faces {a} and {b}");
            // spared * a * b = spared * a - spared * a * (1 - b)
            linear[a] -= spared;
            left[b][a] += spared;
        }
    }
    let mut least = none;
    for (face, &linear) in linear.iter().enumerate() {
        if linear > 0 {
            left[source][face] += linear;
        } else {
            left[face][sink] -= linear;
            least += linear;
        }
    }
    while let Some(path) = path(&left, source, sink) {
        let steps = || path.windows(2).map(|step| (step[0], step[1]));
        let flow = steps().map(|(a, b)| left[a][b]).min().expect("a path has a step");
        least += flow;
        for (a, b) in steps() {
            left[a][b] -= flow;
            left[b][a] += flow;
        }
    }
    least
}

fn path(left: &[Vec<i64>], source: usize, sink: usize) -> Option<Vec<usize>> {
    let mut before = vec![None; left.len()];
    let mut waiting = VecDeque::from([source]);
    while let Some(node) = waiting.pop_front() {
        for next in 0..left.len() {
            if left[node][next] > 0 && next != source && before[next].is_none() {
                before[next] = Some(node);
                waiting.push_back(next);
            }
        }
    }
    let mut path = vec![sink];
    while let Some(node) = before[*path.last()?] {
        path.push(node);
    }
    path.reverse();
    (path.len() > 1).then_some(path)
}
