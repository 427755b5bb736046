//! Sizes of memory as text.

/// Units of sizes, and how many bits to shift by.
const UNITS: [(&str, u32); 4] = [("KiB", 10), ("MiB", 20), ("GiB", 30), ("TiB", 40)];

/// A number of bytes, or of one of these units, without regard to the case of its letters.
pub fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let shift = match unit.trim_start() {
        "" => Some(0),
        unit => UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit)).map(|(_, shift)| *shift),
    };
    let size = shift.zip(number.parse::<u64>().ok()).and_then(|(shift, number)| number.checked_mul(1 << shift));
    let size = size.filter(|&size| size > 0);
    size.ok_or_else(|| {
        "a size is a whole number of bytes, KiB, MiB, GiB or TiB, such as 512MiB, from 1 byte to less than 16777216TiB"
            .to_owned()
    })
}

/// A number of bytes for people: in the largest unit of which there is one, rounded up to a tenth.
pub fn size(bytes: u64) -> String {
    match UNITS.iter().rev().find(|(_, shift)| bytes >> shift > 0) {
        Some((name, shift)) => {
            let tenths = (u128::from(bytes) * 10).div_ceil(1 << shift);
            match tenths % 10 {
                0 => format!("{} {name}", tenths / 10),
                tenth => format!("{}.{tenth} {name}", tenths / 10),
            }
        }
        None => format!("{bytes} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, expected) in [
            ("1", 1),
            ("1000", 1000),
            ("1KiB", 1024),
            ("4GiB", 4 << 30),
            ("4 gib", 4 << 30),
            ("3TiB", 3 << 40),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["", "0", "0GiB", "GiB", "-1", "1.5GiB", "4GB", "4g", "1 2", "18446744073709551616", "16777216TiB"]
        {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_written() {
        for (bytes, expected) in [
            (0, "0 bytes"),
            (1023, "1023 bytes"),
            (1024, "1 KiB"),
            (1025, "1.1 KiB"),
            (4 << 30, "4 GiB"),
            ((9 << 30) + (1 << 29), "9.5 GiB"),
            (u64::MAX, "16777216 TiB"),
        ] {
            assert_eq!(size(bytes), expected);
        }
    }

    #[test]
    fn the_default_is_the_library_s() {
        assert_eq!(bytes("4GiB"), Ok(rimline::gltf::LoadOptions::DEFAULT_MEMORY_LIMIT));
    }
}
