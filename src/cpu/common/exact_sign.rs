//! The sign of `det[b − a, c − a, l − w·a]` for all finite `f32`. The WGSL is `wgsl/common/exact_sign.wgsl`.

/// The number of digits, of 24 bits each. 48 digits hold every sum of products of four finite `f32`.
const DIGITS: usize = 48;
const DIGIT: u32 = 0x00ff_ffff;

/// A float as an integer. The value is `mantissa · 2^(exponent − 149)`.
#[derive(Clone, Copy, Default)]
struct Integer {
    mantissa: u32,
    exponent: u32,
    negative: bool,
}

impl Integer {
    const ONE: Self = Self { mantissa: 1, exponent: 149, negative: false };

    fn new(value: f32) -> Self {
        let bits = value.to_bits();
        let exponent = bits >> 23 & 0xff;
        let implied = if exponent == 0 { 0 } else { 0x0080_0000 };
        Self {
            mantissa: bits & 0x007f_ffff | implied,
            exponent: exponent.max(1) - 1,
            negative: value.is_sign_negative(),
        }
    }
}

/// A product of four operands, by their index among a, b, c, l (three each), w and 1.
type Term = [usize; 4];

/// The determinant is `det(b, c, l) + det(a, b, l) + det(c, a, l) + w·det(a, c, b)`. These are 24 products of four;
/// those without w have a factor of 1. The second product of each pair is subtracted.
const TERMS: [Term; 24] = {
    // The first operands of the three vectors of each determinant, and the factor.
    const DETERMINANTS: [Term; 4] = [[3, 6, 9, 13], [0, 3, 9, 13], [6, 0, 9, 13], [0, 6, 3, 12]];
    let mut terms = [[0; 4]; 24];
    let mut term = 0;
    while term < 24 {
        let [x, y, z, factor] = DETERMINANTS[term / 6];
        let axis = term % 6 / 2;
        let turned = term % 2;
        terms[term] = [x + axis, y + (axis + 1 + turned) % 3, z + (axis + 2 - turned) % 3, factor];
        term += 1;
    }
    terms
};

/// Returns 1, 0 or −1. All numbers are finite. The light is `(l, w)`.
pub(crate) fn exact_sign(a: [f32; 3], b: [f32; 3], c: [f32; 3], light: [f32; 4]) -> i32 {
    let mut operands = [Integer::ONE; 14];
    for (operand, value) in operands.iter_mut().zip(a.into_iter().chain(b).chain(c).chain(light)) {
        *operand = Integer::new(value);
    }
    let exponent_of = |term: &Term| term.iter().map(|&at| operands[at].exponent).sum::<u32>();
    let is_zero = |term: &Term| term.iter().any(|&at| operands[at].mantissa == 0);
    let (least, most) = TERMS
        .iter()
        .filter(|term| !is_zero(term))
        .fold((u32::MAX, 0), |(least, most), term| (least.min(exponent_of(term)), most.max(exponent_of(term))));
    if least > most {
        return 0;
    }
    let used = ((most - least) as usize / 24 + 6).min(DIGITS);
    let mut digits = [0_i32; DIGITS];
    for (index, term) in TERMS.iter().enumerate() {
        if !is_zero(term) {
            let factors = term.map(|at| operands[at]);
            add_term(&mut digits, factors, index % 2 != 0, exponent_of(term) - least);
        }
    }
    let (mut carry, mut any_digit) = (0, 0);
    for digit in &digits[..used] {
        let sum = digit + carry;
        any_digit |= sum & DIGIT as i32;
        carry = sum >> 24;
    }
    match carry {
        ..0 => -1,
        0 => i32::from(any_digit != 0),
        1.. => 1,
    }
}

/// Adds a product to the digits, `above` bits over the lowest digit.
fn add_term(digits: &mut [i32; DIGITS], factors: [Integer; 4], turned: bool, above: u32) {
    let [p, q, r, s] = factors.map(|factor| factor.mantissa);
    let [low, high] = multiply(p, q);
    let [first, second, third, _] = multiply_three([low, high, 0], r);
    let product = multiply_three([first, second, third], s);
    let negative = factors.iter().fold(turned, |negative, factor| negative != factor.negative);
    let (digit, shift) = ((above / 24) as usize, above % 24);
    let mut add = |at: usize, value: u32| digits[at] += if negative { -(value as i32) } else { value as i32 };
    for (part, value) in product.into_iter().enumerate() {
        add(digit + part, (value & (DIGIT >> shift)) << shift);
        add(digit + part + 1, value >> (24 - shift));
    }
}

/// The 48-bit product of two digits, as two digits.
fn multiply(a: u32, b: u32) -> [u32; 2] {
    let product = u64::from(a) * u64::from(b);
    [product as u32 & DIGIT, (product >> 24) as u32]
}

/// Three digits times one.
fn multiply_three(a: [u32; 3], b: u32) -> [u32; 4] {
    let [low, middle, high] = a.map(|digit| multiply(digit, b));
    let second = low[1] + middle[0];
    let third = middle[1] + high[0] + (second >> 24);
    [low[0], second & DIGIT, third & DIGIT, high[1] + (third >> 24)]
}
