//! The input of the macro: `[[visibility] Name =] "path" [, option = value]*`.

use modyn_codegen::diagnostics::{Severity, suggest};
use modyn_codegen::{
    Base, Contact, ContactKind, Friction, Loop, LoopConstraintKind, LoopEnd, Mimic,
};
use modyn_codegen::{Builder, FloatType, Function, ModuleChoice};
use proc_macro2::{Span, TokenTree};
use quote::ToTokens as _;
use syn::ext::IdentExt as _;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Error, Ident, Lit, LitBool, LitStr, Path, Result, Token, Visibility};

/// The macro's input.
pub(crate) struct Input {
    pub path: String,
    /// The place of errors.
    pub span: Span,
    pub builder: Builder,
}

impl Parse for Input {
    fn parse(input: ParseStream<'_>) -> Result<Self> {
        let mut builder = Builder::new();
        let visibility: Visibility = input.parse()?;
        if input.peek(Ident::peek_any) {
            let name = Ident::parse_any(input)?.unraw().to_string();
            builder = builder.type_name(name).visibility(visibility.to_token_stream().to_string());
            input.parse::<Token![=]>().map_err(|error| {
                Error::new(
                    error.span(),
                    "expected `=` and the path of a description: `\"robots/arm.urdf\"`",
                )
            })?;
        } else if !matches!(visibility, Visibility::Inherited) {
            return Err(input.error("a visibility goes with a name: `pub Name = \"path\"`"));
        }
        let literal: LitStr = input.parse().map_err(|error| {
            Error::new(error.span(), "expected the path of a description: `\"robots/arm.urdf\"`")
        })?;
        let mut errors: Option<Error> = None;
        let mut given = Vec::new();
        while !input.is_empty() {
            match option(builder.clone(), &mut given, input) {
                Ok(with_option) => builder = with_option,
                Err(error) => {
                    match &mut errors {
                        Some(errors) => errors.combine(error),
                        None => errors = Some(error),
                    }
                    // Skips to the next option, to report all errors at once.
                    while !input.is_empty() && !input.peek(Token![,]) {
                        input.parse::<TokenTree>()?;
                    }
                }
            }
        }
        match errors {
            Some(errors) => Err(errors),
            None => Ok(Self { path: literal.value(), span: literal.span(), builder }),
        }
    }
}

/// The names of all options.
const OPTIONS: [&str; 15] = [
    "gravity",
    "runtime_inertia",
    "payload",
    "functions",
    "modules",
    "scalar",
    "base",
    "mimic",
    "rotors",
    "loops",
    "contacts",
    "friction",
    "share",
    "unphysical_inertia",
    "crate",
];

/// Parses one `, name = value`, or a trailing comma.
fn option(builder: Builder, given: &mut Vec<Ident>, input: ParseStream<'_>) -> Result<Builder> {
    input.parse::<Token![,]>()?;
    if input.is_empty() {
        return Ok(builder);
    }
    let name = Ident::parse_any(input)
        .map_err(|error| Error::new(error.span(), "expected the name of an option"))?;
    if given.contains(&name) {
        return Err(Error::new(name.span(), format!("the option `{name}` is given twice")));
    }
    given.push(name.clone());
    input.parse::<Token![=]>()?;
    match name.to_string().as_str() {
        "gravity" if input.peek(Ident) => {
            choice(input, &[("runtime", ())]).map(|()| builder.runtime_gravity())
        }
        "gravity" => vector(input).map(|gravity| builder.gravity(gravity)),
        "share" => input
            .parse::<LitBool>()
            .map_err(|error| Error::new(error.span(), "expected `true` or `false`"))
            .map(|share| if share.value { builder.share() } else { builder }),
        "runtime_inertia" => strings(input).map(|links| builder.runtime_inertia(links)),
        "payload" => strings(input).map(|links| builder.payload(links)),
        "functions" => functions(input).map(|functions| builder.functions(functions)),
        "modules" => modules(input).map(|modules| builder.modules(modules)),
        "scalar" => choice(input, &[("f64", FloatType::F64), ("f32", FloatType::F32)])
            .map(|float| builder.float(float)),
        "base" => choice(input, &[("fixed", Base::Fixed), ("floating", Base::Floating)])
            .map(|base| builder.base(base)),
        "friction" => friction(input).map(|friction| builder.friction(friction)),
        "rotors" => rotors(builder, input),
        "loops" => loops(builder, input),
        "contacts" => contacts(builder, input),
        "mimic" => {
            let choices = [
                ("follow", Mimic::Follow),
                ("independent", Mimic::Independent),
                ("refuse", Mimic::Refuse),
            ];
            choice(input, &choices).map(|mimic| builder.mimic(mimic))
        }
        "unphysical_inertia" => {
            choice(input, &[("error", Severity::Error), ("warn", Severity::Warning)])
                .map(|severity| builder.unphysical_inertia(severity))
        }
        "crate" => match input.call(Path::parse_mod_style) {
            Ok(path) => Ok(builder.krate(path.to_token_stream().to_string())),
            Err(error) => Err(Error::new(error.span(), "expected a path, such as `::modyn`")),
        },
        other => {
            let help = match suggest(other, OPTIONS.iter().copied()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("options are {}", OPTIONS.join(", ")),
            };
            Err(Error::new(name.span(), format!("there is no option `{other}`; {help}")))
        }
    }
}

/// Parses one of these words.
fn choice<T: Copy>(input: ParseStream<'_>, choices: &[(&str, T)]) -> Result<T> {
    let span = input.span();
    let word = input.call(Ident::parse_any).ok();
    let found = word.and_then(|word| choices.iter().find(|(name, _)| word == name));
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|(name, _)| format!("`{name}`")).collect();
        Error::new(span, format!("expected {}", names.join(" or ")))
    })
}

/// Parses `none`, `viscous`, `coulomb` or `smooth(0.01)`.
fn friction(input: ParseStream<'_>) -> Result<Friction> {
    let choices = [
        ("none", Friction::None),
        ("viscous", Friction::Viscous),
        ("coulomb", Friction::Coulomb),
        ("smooth", Friction::Smooth(f64::NAN)),
    ];
    let chosen = choice(input, &choices)?;
    if !matches!(chosen, Friction::Smooth(_)) {
        return Ok(chosen);
    }
    let content;
    if !input.peek(syn::token::Paren) {
        return Err(input.error("expected a velocity, rad/s or m/s: `smooth(0.01)`"));
    }
    syn::parenthesized!(content in input);
    Ok(Friction::Smooth(number(&content)?))
}

/// Parses `["joint": (inertia, gear_ratio), ...]`.
fn rotors(builder: Builder, input: ParseStream<'_>) -> Result<Builder> {
    let content;
    syn::bracketed!(content in input);
    let rotor = |input: ParseStream<'_>| {
        let joint: LitStr = input.parse()?;
        input.parse::<Token![:]>()?;
        let figures;
        syn::parenthesized!(figures in input);
        let inertia = number(&figures)?;
        figures.parse::<Token![,]>()?;
        Ok((joint.value(), inertia, number(&figures)?))
    };
    let rotors = Punctuated::<_, Token![,]>::parse_terminated_with(&content, rotor)?;
    Ok(rotors.into_iter().fold(builder, |builder, (joint, inertia, gear_ratio)| {
        builder.rotor(joint, inertia, gear_ratio)
    }))
}

/// Parses `["name": type("link", [x, y, z], "link", [x, y, z], axis = [x, y, z]), ...]`; roll, pitch and yaw may follow
/// each position.
fn loops(builder: Builder, input: ParseStream<'_>) -> Result<Builder> {
    let content;
    syn::bracketed!(content in input);
    let loops = Punctuated::<_, Token![,]>::parse_terminated_with(&content, loop_joint)?;
    Ok(loops.into_iter().fold(builder, Builder::loop_joint))
}

fn loop_joint(input: ParseStream<'_>) -> Result<Loop> {
    let name: LitStr = input.parse()?;
    input.parse::<Token![:]>()?;
    let types = ["spherical", "fixed", "revolute", "continuous", "prismatic"];
    let joint_type = choice(input, &types.map(|joint_type| (joint_type, joint_type)))?;
    let figures;
    syn::parenthesized!(figures in input);
    let first = loop_end(&figures)?;
    figures.parse::<Token![,]>()?;
    let ends = [first, loop_end(&figures)?];
    figures.parse::<Option<Token![,]>>()?;
    let mut axis = None;
    if !figures.is_empty() {
        let span = figures.span();
        choice(&figures, &[("axis", ())])?;
        figures.parse::<Token![=]>()?;
        axis = Some((vector(&figures)?, span));
        figures.parse::<Option<Token![,]>>()?;
    }
    let along = axis.map_or([1.0, 0.0, 0.0], |(axis, _)| axis);
    let kind = LoopConstraintKind::of_joint(joint_type, along)
        .ok_or_else(|| Error::new(name.span(), "expected the type of a joint"))?;
    match axis {
        Some((_, span)) if kind.axis().is_none() => {
            Err(Error::new(span, format!("a loop joint of type `{joint_type}` has no axis")))
        }
        _ if !figures.is_empty() => Err(figures.error("expected `)`")),
        _ => Ok(Loop { name: name.value(), kind, ends }),
    }
}

/// `["name": point("link"), "name": surface("link", [x, y, z], [roll, pitch, yaw]), ...]`
fn contacts(builder: Builder, input: ParseStream<'_>) -> Result<Builder> {
    let content;
    syn::bracketed!(content in input);
    let contacts = Punctuated::<_, Token![,]>::parse_terminated_with(&content, contact)?;
    Ok(contacts.into_iter().fold(builder, Builder::contact))
}

fn contact(input: ParseStream<'_>) -> Result<Contact> {
    let name: LitStr = input.parse()?;
    input.parse::<Token![:]>()?;
    let kind = choice(input, &[("point", ContactKind::Point), ("surface", ContactKind::Surface)])?;
    let content;
    syn::parenthesized!(content in input);
    let link: LitStr = content.parse()?;
    let mut numbers = [[0.0; 3]; 2];
    for vector_of in &mut numbers {
        content.parse::<Option<Token![,]>>()?;
        if !content.is_empty() {
            *vector_of = vector(&content)?;
        }
    }
    content.parse::<Option<Token![,]>>()?;
    if !content.is_empty() {
        return Err(content.error("expected `)`: a link, then a place and roll, pitch, yaw"));
    }
    let [xyz, rpy] = numbers;
    Ok(Contact { name: name.value(), kind, end: LoopEnd { link: link.value(), xyz, rpy } })
}

/// Parses `"link", [x, y, z]` or `"link", [x, y, z], [roll, pitch, yaw]`.
fn loop_end(input: ParseStream<'_>) -> Result<LoopEnd> {
    let link: LitStr = input.parse()?;
    input.parse::<Token![,]>()?;
    let xyz = vector(input)?;
    let mut rpy = [0.0; 3];
    if input.peek(Token![,]) && input.peek2(syn::token::Bracket) {
        input.parse::<Token![,]>()?;
        rpy = vector(input)?;
    }
    Ok(LoopEnd { link: link.value(), xyz, rpy })
}

/// Parses `["a", "b"]`.
fn strings(input: ParseStream<'_>) -> Result<Vec<String>> {
    let content;
    syn::bracketed!(content in input);
    let strings = Punctuated::<LitStr, Token![,]>::parse_terminated(&content)?;
    Ok(strings.iter().map(LitStr::value).collect())
}

/// Parses `all`, `default`, or a list of names of functions that may contain these two.
fn functions(input: ParseStream<'_>) -> Result<Vec<Function>> {
    if !input.peek(syn::token::Bracket) {
        return function(input);
    }
    let content;
    syn::bracketed!(content in input);
    let lists = Punctuated::<_, Token![,]>::parse_terminated_with(&content, function)?;
    Ok(lists.into_iter().flatten().collect())
}

fn function(input: ParseStream<'_>) -> Result<Vec<Function>> {
    let name = Ident::parse_any(input).map_err(|error| {
        Error::new(error.span(), "expected names of functions, `default` or `all`")
    })?;
    match name.to_string().as_str() {
        "all" => Ok(Function::ALL.to_vec()),
        "default" => Ok(Function::DEFAULT.to_vec()),
        other => Function::from_name(other)
            .map(|function| vec![function])
            .ok_or_else(|| Error::new(name.span(), Function::unknown(other))),
    }
}

/// Parses `[x, y, z]`.
fn vector(input: ParseStream<'_>) -> Result<[f64; 3]> {
    let span = input.span();
    let content;
    syn::bracketed!(content in input);
    let numbers = Punctuated::<_, Token![,]>::parse_terminated_with(&content, number)?;
    let count = numbers.len();
    let numbers: Vec<f64> = numbers.into_iter().collect();
    numbers
        .try_into()
        .map_err(|_| Error::new(span, format!("expected three numbers, there are {count}")))
}

/// Parses a number with an optional sign.
fn number(input: ParseStream<'_>) -> Result<f64> {
    let span = input.span();
    let sign = if input.parse::<Option<Token![-]>>()?.is_some() { -1.0 } else { 1.0 };
    let magnitude = match input.parse() {
        Ok(Lit::Float(number)) if matches!(number.suffix(), "" | "f32" | "f64") => {
            number.base10_parse::<f64>().ok()
        }
        Ok(Lit::Int(number)) if number.suffix().is_empty() => number.base10_parse::<f64>().ok(),
        _ => None,
    };
    let magnitude = magnitude.ok_or_else(|| Error::new(span, "expected a number"))?;
    Ok(sign * magnitude)
}

/// Parses `chains`, `links` or `[["link", ...], ...]`.
fn modules(input: ParseStream<'_>) -> Result<ModuleChoice> {
    if input.peek(Ident) {
        let (chains, links) = (&ModuleChoice::Chains, &ModuleChoice::Links);
        return choice(input, &[("chains", chains), ("links", links)]).cloned();
    }
    let content;
    syn::bracketed!(content in input);
    let module = |module: ParseStream<'_>| {
        let names;
        syn::bracketed!(names in module);
        let names = Punctuated::<LitStr, Token![,]>::parse_terminated(&names)?;
        Ok(names.iter().map(LitStr::value).collect())
    };
    let list = Punctuated::<_, Token![,]>::parse_terminated_with(&content, module)?;
    Ok(ModuleChoice::List(list.into_iter().collect()))
}
