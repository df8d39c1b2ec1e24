//! The type of sets of active contacts.

use std::fmt::Write as _;

use super::{Robot, docs};
use crate::names;

impl Robot<'_> {
    /// Returns the names of the contacts.
    pub(super) fn contact_names(&self) -> Vec<&str> {
        self.model.contacts().iter().map(|contact| contact.name.as_str()).collect()
    }

    /// Returns the name of the type of sets of active contacts; `()` without contacts.
    pub(super) fn contacts_type(&self) -> String {
        if self.model.contacts().is_empty() {
            "()".into()
        } else {
            format!("{}Contacts", self.name)
        }
    }

    /// Prints the structure with a member for each contact; nothing without contacts.
    pub(super) fn contact_set(&self, text: &mut String) {
        let names = self.contact_names();
        if names.is_empty() {
            return;
        }
        let name = self.name;
        let vis = &self.options.visibility;
        let named = names::fields(&names, &[]).into_iter().zip(&names);
        let fields: Vec<String> = named
            .map(|(field, contact)| {
                format!(
                    "    /// Whether contact {} is active.\n    pub {field}: bool,\n",
                    docs::code(contact)
                )
            })
            .collect();
        let kind = format!("{name}Contacts");
        let lint = names::camel_case_lint([&*kind].into_iter());
        let _ = writeln!(
            text,
            "/// A set of active contacts of [`{name}`]; empty by default.\n\
             #[allow(dead_code)]\n\
             {lint}#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]\n\
             {vis} struct {kind} {{\n{}}}\n",
            fields.concat()
        );
    }

    /// Prints the functions of that structure.
    pub(super) fn contact_functions(&self, text: &mut String) {
        let names = self.contact_names();
        let count = names.len();
        let contacts_type = self.contacts_type();
        if count == 0 {
            return;
        }
        let fields = names::fields(&names, &[]);
        let all = |value: &str| {
            let members: Vec<String> =
                fields.iter().map(|field| format!("{field}: {value}")).collect();
            members.join(", ")
        };
        let list = |prefix: &str| {
            let members: Vec<String> =
                fields.iter().map(|field| format!("{prefix}{field}")).collect();
            members.join(", ")
        };
        let _ = writeln!(
            text,
            "impl {contacts_type} {{\n\
             /// No contact is active.\n\
             pub const NONE: Self = Self {{ {} }};\n\
             /// All contacts are active.\n\
             pub const ALL: Self = Self {{ {} }};\n\
             /// Returns the set of the contacts whose entry is `true`, in the order of `CONTACT_NAMES`.\n\
             #[must_use]\n\
             pub const fn from_array([{}]: [bool; {count}]) -> Self {{\n    Self {{ {} }}\n}}\n\
             /// Returns for each contact whether it is active, in the order of `CONTACT_NAMES`.\n\
             #[must_use]\n\
             pub const fn to_array(self) -> [bool; {count}] {{\n    [{}]\n}}\n\
             fn numbers<T: __modyn::Scalar>(self) -> [T; {count}] {{\n    \
             self.to_array().map(|active| T::from_f64(::core::convert::Into::into(active)))\n}}\n}}\n",
            all("false"),
            all("true"),
            list(""),
            list(""),
            list("self."),
        );
        if !self.options.self_contained {
            let _ = writeln!(
                text,
                "impl __modyn::ContactSet for {contacts_type} {{\n\
                 const NONE: Self = Self::NONE;\nconst ALL: Self = Self::ALL;\n}}\n"
            );
        }
    }
}
