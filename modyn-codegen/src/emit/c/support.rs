//! The support functions of generated C besides arithmetic: the runtime's operations, for one
//! precision.

use std::collections::{BTreeMap, BTreeSet};

use modyn_runtime::{ELEMENTARY_F32, ELEMENTARY_F64, ElementaryNumbers};
use modyn_runtime::{FRAC_1_PI_BITS, PI_BITS, SIN_COS_F32, SIN_COS_F64, SinCosNumbers};

use super::FloatType;
use super::literal;
use crate::emit::support::Support;

impl Support {
    fn c(self) -> &'static str {
        match self {
            Self::SinCos => include_str!("sin_cos.c"),
            Self::Atan2 => include_str!("atan2.c"),
            Self::Logarithm => include_str!("ln.c"),
            Self::Maximum => include_str!("maximum.c"),
        }
    }

    /// Returns whether the function reads the bits of numbers.
    fn reads_bits(self) -> bool {
        self != Self::Maximum
    }

    /// Returns whether the function makes numbers from bits.
    fn writes_bits(self) -> bool {
        matches!(self, Self::SinCos | Self::Logarithm)
    }
}

/// The words before the type of a function.
pub(in crate::emit) struct Qualifiers {
    /// The words before a function that is called for each angle.
    pub function: &'static str,
    /// The words before a function whose calls are rare.
    pub rare_function: &'static str,
}

impl Qualifiers {
    /// The qualifiers of C99.
    pub const C: Self = Self { function: "static", rare_function: "MODYN_RARE static" };
}

/// Returns the text of these functions and of those that they call. In the templates, words in
/// capitals depend on the precision and the language, and `R(..)` is a literal.
pub(in crate::emit) fn text(
    used: &BTreeSet<Support>,
    float: FloatType,
    qualifiers: &Qualifiers,
) -> String {
    let mut text = String::new();
    if used.iter().any(|support| support.reads_bits()) {
        text += "/* Numbers are as long as their bits. */\n\
                 typedef char modyn_size_of_numbers[(sizeof(REAL) == sizeof(BITS)) ? 1 : -1];\n\n";
        text += include_str!("bits.c");
    }
    if used.iter().any(|support| support.writes_bits()) {
        text += include_str!("from_bits.c");
    }
    text.extend(used.iter().map(|support| support.c()));
    let mut words = substitutions(float);
    words.insert("FUNCTION", qualifiers.function.into());
    words.insert("RARE_FUNCTION", qualifiers.rare_function.into());
    let text = substitute(&text, |word| words.get(word).cloned());
    literals(&text, float)
}

/// Returns the words that depend on the precision.
fn substitutions(float: FloatType) -> BTreeMap<&'static str, String> {
    let of_precision: &[(&str, &str)] = match float {
        FloatType::F64 => &[
            ("REAL", "double"),
            ("BITS", "unsigned long long"),
            ("ABS", "fabs"),
            ("SIGN", "63"),
            ("MANTISSA", "52"),
            ("DIGITS", "53"),
            ("EXPONENTS", "0x7ff"),
            ("BIAS", "1023"),
            ("SCALE", "961U"),
            ("ANGLE", "(double)reduced.angle"),
            ("ERROR", "3e-16"),
        ],
        FloatType::F32 => &[
            ("REAL", "float"),
            ("BITS", "unsigned int"),
            ("ABS", "fabsf"),
            ("SIGN", "31"),
            ("MANTISSA", "23"),
            ("DIGITS", "24"),
            ("EXPONENTS", "0xff"),
            ("BIAS", "127"),
            ("SCALE", "97U"),
            ("ANGLE", "(float)(unsigned int)(reduced.angle >> 32)"),
            ("ERROR", "1.5e-7"),
        ],
    };
    let (sin_cos, elementary) = match float {
        FloatType::F64 => (sin_cos_words(&SIN_COS_F64), elementary_words(&ELEMENTARY_F64, "ULL")),
        FloatType::F32 => (sin_cos_words(&SIN_COS_F32), elementary_words(&ELEMENTARY_F32, "U")),
    };
    let given = of_precision.iter().map(|(word, text)| (*word, (*text).to_string()));
    given.chain(bits_words()).chain(sin_cos).chain(elementary).collect()
}

/// Returns the words of the reduction of large angles with integers, from the runtime's constants.
fn bits_words() -> [(&'static str, String); 4] {
    // A word of zeros follows, so that each of the others has a successor.
    let limbs: Vec<String> =
        FRAC_1_PI_BITS.iter().chain(&[0]).map(|word| format!("{word:#018x}ULL")).collect();
    let lines: Vec<String> = limbs.chunks(4).map(|line| line.join(", ")).collect();
    [
        ("LIMBS", limbs.len().to_string()),
        ("LAST_LIMB", format!("{}U", FRAC_1_PI_BITS.len() - 1)),
        ("FRAC_1_PI_BITS", lines.join(",\n        ")),
        ("PI_BITS", format!("{PI_BITS:#018x}ULL")),
    ]
}

/// Returns the words of logarithm and arctangent, from the runtime's constants. Literals of bits
/// end in `unsigned`.
fn elementary_words<const L: usize, const A: usize>(
    numbers: &ElementaryNumbers<L, A>,
    unsigned: &str,
) -> [(&'static str, String); 17] {
    let series = |terms: &[(f64, f64)]| {
        let term = |(over, under): &(f64, f64)| format!("R({over:?}) / R({under:?})");
        terms.iter().map(term).collect::<Vec<_>>().join(", ")
    };
    [
        ("LN_TERMS", L.to_string()),
        ("LN_SERIES", series(&numbers.logarithm)),
        ("ATAN_TERMS", A.to_string()),
        ("ATAN_SERIES", series(&numbers.arctangent)),
        ("TWO_UP", format!("{:?}", numbers.two_up)),
        ("LN_2", format!("{:?}", numbers.ln_2.0)),
        ("LN_2_REST", format!("{:?}", numbers.ln_2.1)),
        ("MIN_POSITIVE", format!("{:?}", numbers.min_positive)),
        ("ROOT_HALF", format!("{:#x}{unsigned}", numbers.root_half_bits)),
        ("ROOT_3", format!("{:?}", numbers.root_3)),
        ("TAN_15", format!("{:?}", numbers.tan_15)),
        ("PI", format!("{:?}", numbers.pi.0)),
        ("PI_REST", format!("{:?}", numbers.pi.1)),
        ("HALF_PI", format!("{:?}", numbers.half_pi.0)),
        ("HALF_REST", format!("{:?}", numbers.half_pi.1)),
        ("SIXTH_PI", format!("{:?}", numbers.sixth_pi.0)),
        ("SIXTH_REST", format!("{:?}", numbers.sixth_pi.1)),
    ]
}

/// Returns the words of sine and cosine, from the runtime's constants.
fn sin_cos_words<const P: usize, const M: usize, const N: usize>(
    numbers: &SinCosNumbers<P, M, N>,
) -> [(&'static str, String); 8] {
    let list = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|number| format!("R({number:?})")).collect();
        numbers.join(", ")
    };
    let reduced = |x: String, part: &f64| format!("((n * R({part:?})) + {x})");
    [
        ("LIMIT", format!("{:?}", numbers.limit)),
        ("ROUND", format!("{:?}", numbers.round)),
        ("ONE_OVER_PI", format!("{:?}", core::f64::consts::FRAC_1_PI)),
        ("REDUCTION", numbers.minus_pi.iter().fold("x".into(), reduced)),
        ("SINES", M.to_string()),
        ("COSINES", N.to_string()),
        ("SINE_COEFFICIENTS", list(&numbers.sine)),
        ("COSINE_COEFFICIENTS", list(&numbers.cosine)),
    ]
}

/// Returns the text with words replaced.
fn substitute(text: &str, with: impl Fn(&str) -> Option<String>) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 4);
    let mut rest = text;
    let in_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    while let Some(start) = rest.find(in_word) {
        out += &rest[..start];
        rest = &rest[start..];
        let (word, after) = rest.split_at(rest.find(|c: char| !in_word(c)).unwrap_or(rest.len()));
        out += &with(word).unwrap_or_else(|| word.into());
        rest = after;
    }
    out + rest
}

/// Returns the text with each `R(number)` replaced by a literal.
fn literals(text: &str, float: FloatType) -> String {
    let mut parts = text.split("R(");
    let mut out: String = parts.next().unwrap_or_default().into();
    for part in parts {
        let number =
            part.split_once(')').and_then(|(number, rest)| Some((number.parse().ok()?, rest)));
        match number {
            Some((value, rest)) => out += &[&literal(value, float), rest].concat(),
            None => out += &["R(", part].concat(),
        }
    }
    out
}
