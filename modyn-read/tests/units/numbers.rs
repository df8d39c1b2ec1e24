//! Numbers of attributes.

use modyn_read::diagnostics::Code;
use modyn_read::internals::numbers;

fn code<const N: usize>(text: &str) -> Result<[f64; N], Code> {
    numbers(text).map_err(|bad| bad.code)
}

#[test]
fn however_it_is_written() {
    assert_eq!(code("\t1\r\n  +2.5   -3e-2 "), Ok([1.0, 2.5, -0.03]));
    assert_eq!(code(".5 5. 1E3"), Ok([0.5, 5.0, 1000.0]));
    assert_eq!(code("-0"), Ok([0.0]));
}

#[test]
fn numbers_must_be_finite() {
    for text in ["nan", "NaN", "-inf", "+Infinity", "1e400", "-1e999"] {
        assert_eq!(code::<1>(text), Err(Code::NotFinite), "{text}");
    }
    for text in ["0x10", "1,5", "one", "1.2.3", "e5", ".", "+", "1e", "--1", "1_000", "\u{661}"] {
        assert_eq!(code::<1>(text), Err(Code::BadNumber), "{text}");
    }
    for text in ["", "1 2", "1 2 3 4", " "] {
        assert_eq!(code::<3>(text), Err(Code::NumberCount), "{text}");
    }
    assert_eq!(code::<3>("0 foo 0 1"), Err(Code::BadNumber));
}
