//! What stands in the macro: `[visibility] [Name =] "path" [, option = value]*`.

use modyn_codegen::error::Severity;
use modyn_codegen::urdf::Mimic;
use modyn_codegen::{Builder, FloatType, ModuleChoice};
use proc_macro2::Span;
use quote::ToTokens as _;
use syn::ext::IdentExt as _;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Expr, ExprArray, Ident, LitStr, Path, Token, Visibility};

/// The macro's input.
pub(crate) struct Input {
    pub path: String,
    /// Where errors are shown.
    pub span: Span,
    pub builder: Builder,
}

impl Parse for Input {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut builder = Builder::new();
        let visibility: Visibility = input.parse()?;
        if input.peek(Ident) {
            builder = builder.type_name(input.parse::<Ident>()?.to_string());
            builder = builder.visibility(visibility.to_token_stream().to_string());
            input.parse::<Token![=]>()?;
        } else if !matches!(visibility, Visibility::Inherited) {
            return Err(input.error("a visibility goes with a name: `pub Name = \"path\"`"));
        }
        let literal: LitStr = input.parse()?;
        let mut errors: Option<syn::Error> = None;
        while !input.is_empty() {
            input.parse::<Token![,]>()?;
            if input.is_empty() {
                break;
            }
            let name = Ident::parse_any(input)?;
            input.parse::<Token![=]>()?;
            match option(builder.clone(), &name, input) {
                Ok(with_option) => builder = with_option,
                Err(error) => {
                    // On to the next option, to report all errors at once.
                    while !input.is_empty() && !input.peek(Token![,]) {
                        input.parse::<proc_macro2::TokenTree>()?;
                    }
                    match &mut errors {
                        Some(errors) => errors.combine(error),
                        None => errors = Some(error),
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

/// One `name = value`.
fn option(builder: Builder, name: &Ident, input: ParseStream<'_>) -> syn::Result<Builder> {
    match name.to_string().as_str() {
        "gravity" => Ok(builder.gravity(vector(&input.parse()?)?)),
        "modules" => Ok(builder.modules(modules(input)?)),
        "scalar" => choice(input, &[("f64", FloatType::F64), ("f32", FloatType::F32)])
            .map(|float| builder.float(float)),
        "base" => {
            let base: Ident = input.call(Ident::parse_any)?;
            match base.to_string().as_str() {
                "fixed" => Ok(builder),
                "floating" => {
                    Err(syn::Error::new(base.span(), "a floating base is not supported yet"))
                }
                _ => Err(syn::Error::new(base.span(), "expected `fixed`")),
            }
        }
        "mimic" => choice(input, &[("refuse", Mimic::Refuse), ("independent", Mimic::Independent)])
            .map(|mimic| builder.mimic(mimic)),
        "unphysical_inertia" => {
            choice(input, &[("error", Severity::Error), ("warn", Severity::Warning)])
                .map(|severity| builder.unphysical_inertia(severity))
        }
        "crate" => {
            Ok(builder.krate(input.call(Path::parse_mod_style)?.to_token_stream().to_string()))
        }
        other => Err(syn::Error::new(
            name.span(),
            format!(
                "there is no option `{other}`; options are gravity, modules, scalar, base, mimic, \
                 unphysical_inertia, crate"
            ),
        )),
    }
}

/// One of these words.
fn choice<T: Clone>(input: ParseStream<'_>, choices: &[(&str, T)]) -> syn::Result<T> {
    let word = input.call(Ident::parse_any)?;
    choices.iter().find(|(name, _)| word == name).map(|(_, value)| value.clone()).ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|(name, _)| format!("`{name}`")).collect();
        syn::Error::new(word.span(), format!("expected {}", names.join(" or ")))
    })
}

/// `[x, y, z]`
fn vector(array: &ExprArray) -> syn::Result<[f64; 3]> {
    let numbers: Vec<f64> = array.elems.iter().map(number).collect::<syn::Result<_>>()?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| {
        syn::Error::new_spanned(array, format!("expected three numbers, there are {count}"))
    })
}

/// A number, perhaps with a sign.
fn number(expr: &Expr) -> syn::Result<f64> {
    let text = expr.to_token_stream().to_string().replace([' ', '_'], "");
    text.parse().map_err(|_| syn::Error::new_spanned(expr, "expected a number"))
}

/// `chains`, `links` or `[["link", ...], ...]`
fn modules(input: ParseStream<'_>) -> syn::Result<ModuleChoice> {
    if input.peek(Ident) {
        return choice(input, &[("chains", ModuleChoice::Chains), ("links", ModuleChoice::Links)]);
    }
    let content;
    syn::bracketed!(content in input);
    let mut list = Vec::new();
    while !content.is_empty() {
        let module;
        syn::bracketed!(module in content);
        let names = Punctuated::<LitStr, Token![,]>::parse_terminated(&module)?;
        list.push(names.iter().map(LitStr::value).collect());
        if content.is_empty() {
            break;
        }
        content.parse::<Token![,]>()?;
    }
    Ok(ModuleChoice::List(list))
}
