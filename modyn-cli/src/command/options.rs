//! The options of the compiler's table on the command line, with the same names and values as
//! everywhere.

use clap::error::{ContextKind, ContextValue};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use modyn_codegen::options::{
    OPTIONS, OptionRow, OptionValue, Stage, Value, ValueKind, renamed_option,
};
use modyn_codegen::{Builder, Function, ModuleChoice, ReadOptions};

/// The options that were given, with their values.
struct Given(Vec<(&'static OptionRow, Value)>);

impl Given {
    fn configure(&self, builder: Builder) -> Builder {
        // Each value was tried when it was parsed.
        self.0.iter().fold(builder, |builder, (row, value)| {
            builder.clone().set(row.name, value).unwrap_or(builder)
        })
    }

    fn from_matches(matches: &ArgMatches, stage: Stage) -> Self {
        let mut given = Vec::new();
        for row in rows(stage) {
            if row.is_flag() {
                if matches.get_flag(row.name) {
                    given.push((row, Value { at: 0, kind: ValueKind::Word("true".into()) }));
                }
            } else if let Some(values) = matches.get_many::<Value>(row.name) {
                given.extend(values.map(|value| (row, value.clone())));
            }
        }
        Self(given)
    }
}

fn rows(stage: Stage) -> impl Iterator<Item = &'static OptionRow> {
    OPTIONS.iter().filter(move |row| row.stage == stage)
}

/// The option as Clap has it.
fn argument(row: &'static OptionRow) -> Arg {
    let heading = match row.stage {
        Stage::Reading => "Reading the description",
        Stage::Code => "The generated code",
    };
    let help = format!("{} [default: {}]", row.docs.trim(), row.default.replace('`', ""));
    let argument = Arg::new(row.name)
        .long(String::leak(row.name.replace('_', "-")) as &'static str)
        .help(help)
        .help_heading(heading);
    if row.is_flag() {
        return argument.action(ArgAction::SetTrue);
    }
    let form = match row.form {
        "links" => "link",
        list if row.is_list() => list.trim_start_matches('[').trim_end_matches(", ...]"),
        form => form,
    };
    let action = if row.is_list() { ArgAction::Append } else { ArgAction::Set };
    let parse = move |text: &str| {
        let value = if row.is_text() { Ok(Value::text(text)) } else { Value::parse(text) };
        let tried = value.and_then(|value| Builder::new().set(row.name, &value).map(|_| value));
        tried.map_err(|fault| fault.message)
    };
    argument.action(action).value_name(form).allow_hyphen_values(true).value_parser(parse)
}

/// The options of a stage as arguments of a command.
macro_rules! stages {
    ($($(#[$docs:meta])* $name:ident: $stage:ident;)*) => {$(
        $(#[$docs])*
        pub struct $name(Given);

        impl FromArgMatches for $name {
            fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
                Ok(Self(Given::from_matches(matches, Stage::$stage)))
            }

            fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
                *self = Self::from_arg_matches(matches)?;
                Ok(())
            }
        }

        impl Args for $name {
            fn augment_args(command: Command) -> Command {
                command.args(rows(Stage::$stage).map(argument))
            }

            fn augment_args_for_update(command: Command) -> Command {
                Self::augment_args(command)
            }
        }

        impl $name {
            /// The builder with these options.
            pub fn configure(&self, builder: Builder) -> Builder {
                self.0.configure(builder)
            }
        }
    )*};
}

stages! {
    /// How the description is read.
    ReadingOptions: Reading;
    /// The code that is generated.
    CodeOptions: Code;
}

impl ReadingOptions {
    /// For the reader alone.
    pub fn read_options(&self) -> ReadOptions {
        self.configure(Builder::new()).read_options().clone()
    }
}

impl CodeOptions {
    /// Whether the option of this name was given.
    pub fn has(&self, name: &str) -> bool {
        self.0.0.iter().any(|(row, _)| row.name == name)
    }
}

/// Adds the remedy to the error of an option that the command does not have: the option's present
/// name, or that it belongs to `generate`.
pub fn explain(mut error: Error) -> Error {
    if let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) {
        let name = given.trim_start_matches('-').replace('-', "_");
        let tip = match renamed_option(&name) {
            Some(now) => Some(format!("'{given}' is named '--{}' now", now.replace('_', "-"))),
            None => rows(Stage::Code)
                .any(|row| row.name == name)
                .then(|| format!("'{given}' is an option of 'modyn generate'")),
        };
        if let Some(tip) = tip.map(Into::into) {
            error.remove(ContextKind::SuggestedArg);
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
        }
    }
    error
}

/// Clap takes a `Vec` for an option that is given several times.
#[derive(Clone)]
pub struct Functions(pub Vec<Function>);

/// `default,regressor`
pub fn functions(text: &str) -> Result<Functions, String> {
    read(text).map(Functions)
}

/// `chains`, `links` or `[["link", ...], ...]`
pub fn modules(text: &str) -> Result<ModuleChoice, String> {
    read(text)
}

fn read<T: OptionValue>(text: &str) -> Result<T, String> {
    Value::parse(text).and_then(|value| T::read(&value)).map_err(|fault| fault.message)
}

#[cfg(test)]
mod tests {
    use clap::{Args, Command, FromArgMatches};
    use modyn_codegen::options::{OPTIONS, Stage};

    use super::{CodeOptions, Given, ReadingOptions, rows};

    #[test]
    fn the_command_line_knows_each_option() {
        let command =
            CodeOptions::augment_args(ReadingOptions::augment_args(Command::new("modyn")));
        command.clone().debug_assert();
        for row in OPTIONS {
            let long = row.name.replace('_', "-");
            let argument = command.get_arguments().find(|one| one.get_long() == Some(&long));
            assert!(argument.expect(row.name).get_help().is_some(), "{}", row.name);
            let flag = format!("--{long}");
            let given = if row.is_flag() { vec![&*flag] } else { vec![&*flag, row.example] };
            let parsed = command.clone().try_get_matches_from([&["modyn"], &given[..]].concat());
            let matches = parsed.unwrap_or_else(|error| panic!("{error}"));
            let reading = Given::from_matches(&matches, Stage::Reading);
            let code = Given::from_matches(&matches, Stage::Code);
            let names: Vec<&str> =
                reading.0.iter().chain(&code.0).map(|(row, _)| row.name).collect();
            assert_eq!(names, [row.name]);
        }
        assert_eq!(rows(Stage::Reading).count() + rows(Stage::Code).count(), OPTIONS.len());
    }

    #[test]
    fn values_are_tried() {
        let command =
            CodeOptions::augment_args(ReadingOptions::augment_args(Command::new("modyn")));
        let matches = |arguments: &[&str]| {
            command.clone().try_get_matches_from([&["modyn"], arguments].concat())
        };
        for wrong in [["--scalar", "f16"], ["--gravity", "1,2"], ["--functions", "fly"]] {
            assert!(matches(&wrong).is_err(), "{wrong:?}");
        }
        let matched = matches(&[
            "--gravity",
            "-1,0,0",
            "--payload",
            "a, b",
            "--payload",
            "c",
            "--share-limbs",
        ]);
        let matches = matched.expect("good");
        let reading = ReadingOptions::from_arg_matches(&matches).expect("good");
        assert_eq!(reading.read_options().gravity, Some([-1.0, 0.0, 0.0]));
        let code = CodeOptions::from_arg_matches(&matches).expect("good");
        assert!(code.has("share_limbs") && code.has("payload") && !code.has("scalar"));
    }
}
