//! The input of the macro: `[[visibility] Name =] "path" [, option = value]*`.

use modyn_codegen::Builder;
use modyn_codegen::options::{Entries, OPTIONS, Value, unknown_option};
use proc_macro2::{Delimiter, Literal, Spacing, Span, TokenStream, TokenTree};
use quote::ToTokens as _;
use syn::ext::IdentExt as _;
use syn::parse::{Parse, ParseStream};
use syn::{Error, Ident, Lit, LitStr, Result, Token, Visibility};

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

/// One `, name = value`, or a last comma.
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
    let option = name.to_string();
    let value = Text::of_value(input)?;
    let rows = OPTIONS.iter().filter(|row| row.entries == Entries::All);
    let known: Vec<&str> = rows.map(|row| row.name).collect();
    if !known.contains(&&*option) {
        return Err(Error::new(name.span(), unknown_option(&option, &known)));
    }
    Value::parse(&value.text)
        .and_then(|parsed| builder.set(&option, &parsed))
        .map_err(|fault| Error::new(value.span_at(fault.at), fault.message))
}

/// The tokens of a value as the text that the table of options reads, with the place of each.
struct Text {
    text: String,
    /// Where each token begins in the text.
    spans: Vec<(usize, Span)>,
}

impl Text {
    /// The tokens up to the next comma.
    fn of_value(input: ParseStream<'_>) -> Result<Self> {
        let mut collected = Self { text: String::new(), spans: vec![(0, input.span())] };
        while !input.is_empty() && !input.peek(Token![,]) {
            collected.token(input.parse()?);
        }
        Ok(collected)
    }

    fn token(&mut self, token: TokenTree) {
        let span = match &token {
            TokenTree::Group(group) => group.span_open(),
            other => other.span(),
        };
        self.spans.push((self.text.len(), span));
        match token {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::None => ("", ""),
                };
                self.text += open;
                self.tokens(group.stream());
                self.spans.push((self.text.len(), group.span_close()));
                self.text += close;
            }
            TokenTree::Punct(punct) => {
                self.text.push(punct.as_char());
                // A comma does not join what it separates, nor do signs and the colons of paths.
                if punct.spacing() == Spacing::Alone && matches!(punct.as_char(), ',' | '=') {
                    self.text.push(' ');
                }
            }
            TokenTree::Ident(word) => self.word(&word.unraw().to_string()),
            TokenTree::Literal(literal) => self.word(&literal_text(&literal)),
        }
    }

    fn tokens(&mut self, tokens: TokenStream) {
        tokens.into_iter().for_each(|token| self.token(token));
    }

    /// A word; two in a row stay two.
    fn word(&mut self, word: &str) {
        if self.text.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '"' | ']' | ')'))
        {
            self.text.push(' ');
            if let Some((at, _)) = self.spans.last_mut() {
                *at += 1;
            }
        }
        self.text += word;
    }

    /// The token at this place of the text.
    fn span_at(&self, at: usize) -> Span {
        let token = self.spans.iter().rev().find(|(start, _)| *start <= at);
        token.map_or_else(Span::call_site, |(_, span)| *span)
    }
}

/// A literal in the syntax of options: numbers without suffixes, texts with quotes and backslashes
/// escaped.
fn literal_text(literal: &Literal) -> String {
    match Lit::new(literal.clone()) {
        Lit::Str(text) => {
            format!("\"{}\"", text.value().replace('\\', "\\\\").replace('"', "\\\""))
        }
        Lit::Float(number) if matches!(number.suffix(), "" | "f32" | "f64") => {
            number.base10_digits().into()
        }
        Lit::Int(number) if number.suffix().is_empty() => number.base10_digits().into(),
        _ => literal.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use modyn_codegen::options::{Entries, OPTIONS};

    use super::Input;

    #[test]
    fn the_macro_knows_each_option() {
        for row in OPTIONS {
            let text = format!("\"a.urdf\", {} = {}", row.name, row.example);
            let parsed = syn::parse_str::<Input>(&text);
            match row.entries {
                Entries::All => drop(parsed.unwrap_or_else(|error| panic!("{text}: {error}"))),
                Entries::Files => assert!(parsed.is_err(), "{text}"),
            }
        }
    }
}
