//! Weaves mutants into a source: every mutant is in the text, behind a test of its number.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::list::{Mutant, Position};

/// A source with mutants.
pub struct Woven {
    /// The text.
    pub text: String,
    /// The replacements of single mutants, as ranges of bytes of the text.
    pub replacements: Vec<(Range<usize>, Vec<u32>)>,
    /// The expressions with mutants, each with all mutants of its operator.
    pub expressions: Vec<(Range<usize>, Vec<u32>)>,
    /// The match expressions, each with the mutants that delete one of its arms.
    pub matches: Vec<(Range<usize>, Vec<u32>)>,
    /// The mutants that cannot be selected at run time: in constants, constant functions, tests and chains of `let`, and
    /// the results of functions that return `impl Trait`.
    pub not_selectable: Vec<u32>,
}

/// Weaves `mutants` into `source`, without those that `dropped` contains. `call` is the path of the function that tells
/// whether a mutant is selected.
///
/// # Errors
///
/// Returns the parser's error if the source is not Rust.
pub fn weave(
    source: &str,
    mutants: &[Mutant],
    dropped: &BTreeSet<u32>,
    call: &str,
) -> syn::Result<Woven> {
    let tree = syn::parse_file(source)?;
    let mut lines = vec![0];
    lines.extend(source.match_indices('\n').map(|(i, _)| i + 1));
    let mut by_start: HashMap<Position, Vec<usize>> = HashMap::new();
    for (i, mutant) in mutants.iter().enumerate() {
        by_start.entry(mutant.span.start).or_default().push(i);
    }
    let mut weaver = Weaver {
        source,
        lines,
        mutants,
        by_start,
        dropped,
        call,
        edits: Vec::new(),
        expressions: Vec::new(),
        found: BTreeSet::new(),
        constants: 0,
        depth: 1,
    };
    weaver.visit_file(&tree);
    Ok(weaver.finish())
}

/// The order of edits at one place. Closing texts come first, from the inside out, then the opening ones, from the
/// outside in.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Order {
    Statement,
    Close(i64),
    Open(i64),
    Operator,
    Guard,
}

/// A replacement of a range of the source, of no length for an insertion.
struct Edit {
    range: Range<usize>,
    order: Order,
    text: String,
    /// The ranges of the replacements of single mutants in the text.
    replacements: Vec<(Range<usize>, u32)>,
    /// The expression that begins (`true`) or ends (`false`) with this edit.
    expression: Option<(usize, bool)>,
}

impl Edit {
    fn new(range: Range<usize>, order: Order, text: impl Into<String>) -> Self {
        Self { range, order, text: text.into(), replacements: Vec::new(), expression: None }
    }

    fn insert(at: usize, order: Order, text: impl Into<String>) -> Self {
        Self::new(at..at, order, text)
    }

    fn begins(self, expression: usize) -> Self {
        Self { expression: Some((expression, true)), ..self }
    }

    fn ends(self, expression: usize) -> Self {
        Self { expression: Some((expression, false)), ..self }
    }
}

struct Weaver<'a> {
    source: &'a str,
    /// The first byte of each line.
    lines: Vec<usize>,
    mutants: &'a [Mutant],
    by_start: HashMap<Position, Vec<usize>>,
    dropped: &'a BTreeSet<u32>,
    call: &'a str,
    edits: Vec<Edit>,
    /// The mutants of each expression, and whether they delete arms of it.
    expressions: Vec<(Vec<u32>, bool)>,
    found: BTreeSet<u32>,
    /// The number of constants and constant functions around the node.
    constants: usize,
    /// The number of expressions around the node.
    depth: i64,
}

impl Weaver<'_> {
    fn finish(mut self) -> Woven {
        let missing = |mutant: &&Mutant| {
            !self.found.contains(&mutant.id) && !self.dropped.contains(&mutant.id)
        };
        let not_selectable = self.mutants.iter().filter(missing).map(|m| m.id).collect();
        self.edits.sort_by_key(|edit| (edit.range.start, edit.order));
        let mut woven = Woven {
            text: String::new(),
            replacements: Vec::new(),
            expressions: Vec::new(),
            matches: Vec::new(),
            not_selectable,
        };
        let mut at = 0;
        let mut begun = HashMap::new();
        for edit in self.edits {
            assert!(edit.range.start >= at, "edits overlap: {}", edit.text);
            woven.text += &self.source[at..edit.range.start];
            at = edit.range.end;
            let here = woven.text.len();
            if let Some((expression, true)) = edit.expression {
                begun.insert(expression, here);
            }
            for (range, id) in edit.replacements {
                woven.replacements.push((here + range.start..here + range.end, vec![id]));
            }
            woven.text += &edit.text;
            if let Some((expression, false)) = edit.expression {
                let range = begun[&expression]..woven.text.len();
                let (mutants, deletes_arms) = &self.expressions[expression];
                let list = if *deletes_arms { &mut woven.matches } else { &mut woven.expressions };
                list.push((range, mutants.clone()));
            }
        }
        woven.text += &self.source[at..];
        woven
    }

    fn byte(&self, at: Position) -> usize {
        let line = self.lines[at.line - 1];
        let mut characters = self.source[line..].char_indices();
        characters.nth(at.column - 1).map_or(self.source.len(), |(i, _)| line + i)
    }

    /// Returns the mutants of this genre that begin where `span` begins, as indices.
    fn find(&mut self, span: proc_macro2::Span, genre: &str) -> Vec<usize> {
        if self.constants > 0 {
            return Vec::new();
        }
        let start = span.start();
        let start = Position { line: start.line, column: start.column + 1 };
        let here = self.by_start.get(&start).into_iter().flatten().copied();
        let found = here.filter(|&m| self.mutants[m].genre == genre).collect();
        self.take(found)
    }

    /// Marks the mutants as found and returns those that are not dropped.
    fn take(&mut self, mut mutants: Vec<usize>) -> Vec<usize> {
        mutants.retain(|&m| !self.dropped.contains(&self.mutants[m].id));
        self.found.extend(mutants.iter().map(|&m| self.mutants[m].id));
        mutants
    }

    /// Returns the condition that selects a mutant.
    fn selected(&self, m: usize) -> String {
        format!("{}({})", self.call, self.mutants[m].id)
    }

    fn expression(&mut self, mutants: &[usize]) -> usize {
        let mutants = mutants.iter().map(|&m| self.mutants[m].id).collect();
        self.expressions.push((mutants, false));
        self.expressions.len() - 1
    }

    /// Appends `if selected { alternative } else ` for each mutant.
    fn alternatives(
        &self,
        edit: &mut Edit,
        mutants: &[usize],
        alternative: impl Fn(&Mutant) -> String,
    ) {
        for &m in mutants {
            edit.text += &format!("if {} {{ ", self.selected(m));
            let start = edit.text.len();
            edit.text += &alternative(&self.mutants[m]);
            edit.replacements.push((start..edit.text.len(), self.mutants[m].id));
            edit.text += " } else ";
        }
    }

    /// `a + b` becomes `(match (a, b) { (l, r) => if .. { l - r } else { l + r } })`.
    fn binary(&mut self, e: &syn::ExprBinary) {
        let operator = self.operator(e);
        let lazy = matches!(operator, "&&" | "||");
        // A chain of `let` has no values that a match could bind, and no `||`.
        if lazy && (contains_let(&e.left) || contains_let(&e.right)) {
            return;
        }
        let mutants = self.find(e.op.span(), "BinaryOperator");
        if mutants.is_empty() {
            return;
        }
        let whole = e.span().byte_range();
        let start = e.op.span().byte_range().start;
        let operator_range = start..start + operator.len();
        let expression = self.expression(&mutants);
        let (open, close) = (Order::Open(self.depth), Order::Close(-self.depth));
        if lazy {
            // `a && b` is `if !a { a } else { b }`, and `a || b` is `if a { a } else { b }`.
            let not = if operator == "&&" { "!" } else { "" };
            let decided = format!("({not}__l) != {}", self.selected(mutants[0]));
            let between = format!(") {{ __l => if {decided} {{ __l }} else {{ (");
            self.edits.extend([
                Edit::insert(whole.start, open, "(match (").begins(expression),
                Edit::new(operator_range, Order::Operator, between),
                Edit::insert(whole.end, close, ") } })").ends(expression),
            ]);
        } else if is_assignment(operator) {
            // The right side is evaluated first, as for numbers without the match.
            let left = &self.source[whole.start..operator_range.start];
            let mut tail = Edit::insert(whole.end, close, ") { __r => ").ends(expression);
            self.alternatives(&mut tail, &mutants, |m| format!("{left} {} __r", m.replacement));
            tail.text += &format!("{{ {left} {operator} __r }} }})");
            let head = Edit::new(whole.start..operator_range.end, open, "(match (");
            self.edits.extend([head.begins(expression), tail]);
        } else {
            // Comparisons take references.
            let compares = matches!(operator, "==" | "!=" | "<" | "<=" | ">" | ">=");
            let (reference, l, r) =
                if compares { ("&", "*__l", "*__r") } else { ("", "__l", "__r") };
            let mut tail = Edit::insert(whole.end, close, ")) { (__l, __r) => ").ends(expression);
            self.alternatives(&mut tail, &mutants, |m| format!("{l} {} {r}", m.replacement));
            tail.text += &format!("{{ {l} {operator} {r} }} }})");
            self.edits.extend([
                Edit::insert(whole.start, open, format!("(match ({reference}(")).begins(expression),
                Edit::new(operator_range, Order::Operator, format!("), {reference}(")),
                tail,
            ]);
        }
    }

    /// `-a` becomes `(match (a) { v => if .. { v } else { -v } })`.
    fn unary(&mut self, e: &syn::ExprUnary) {
        let operator = match e.op {
            syn::UnOp::Neg(_) => "-",
            syn::UnOp::Not(_) => "!",
            _ => return,
        };
        let mutants = self.find(e.op.span(), "UnaryOperator");
        if mutants.is_empty() {
            return;
        }
        let expression = self.expression(&mutants);
        let whole = e.span().byte_range();
        let (open, close) = (Order::Open(self.depth), Order::Close(-self.depth));
        let mut tail = Edit::insert(whole.end, close, ") { __v => ").ends(expression);
        self.alternatives(&mut tail, &mutants, |_| "__v".into());
        tail.text += &format!("{{ {operator}__v }} }})");
        let head = Edit::new(whole.start..whole.start + 1, open, "(match (");
        self.edits.extend([head.begins(expression), tail]);
    }

    /// A body becomes `{ if .. { return 0.0; } ... }`.
    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        // All returned values of an `impl Trait` have one type, so replacements of another type do not compile.
        if self.constants > 0 || signature.constness.is_some() || returns_impl(signature) {
            return;
        }
        let (Some(first), Some(last)) = (block.stmts.first(), block.stmts.last()) else { return };
        let body = first.span().byte_range().start..last.span().byte_range().end;
        let open = block.brace_token.span.open().byte_range().end;
        let close = block.brace_token.span.close().byte_range().start;
        let replaces = |mutant: &Mutant| {
            let (start, end) = (self.byte(mutant.span.start), self.byte(mutant.span.end));
            mutant.genre == "FnValue"
                && (open..=body.start).contains(&start)
                && (body.end..=close).contains(&end)
        };
        let found = (0..self.mutants.len()).filter(|&m| replaces(&self.mutants[m])).collect();
        let mut edit = Edit::insert(open, Order::Statement, " ");
        for m in self.take(found) {
            edit.text += &format!("if {} {{ ", self.selected(m));
            let start = edit.text.len();
            edit.text += &format!("return {};", self.mutants[m].replacement);
            edit.replacements.push((start..edit.text.len(), self.mutants[m].id));
            edit.text += " } ";
        }
        self.edits.push(edit);
    }

    /// Marks a match expression with the mutants that delete one of its arms.
    fn match_expression(&mut self, e: &syn::ExprMatch) {
        let deleted: Vec<usize> =
            e.arms.iter().flat_map(|arm| self.find(arm.span(), "MatchArm")).collect();
        if deleted.is_empty() {
            return;
        }
        let expression = self.expression(&deleted);
        self.expressions[expression].1 = true;
        let span = e.span().byte_range();
        let (open, close) = (Order::Open(self.depth), Order::Close(-self.depth));
        self.edits.push(Edit::insert(span.start, open, "").begins(expression));
        self.edits.push(Edit::insert(span.end, close, "").ends(expression));
    }

    /// An arm gets a guard, or a guard gets a further condition.
    fn arm(&mut self, arm: &syn::Arm) {
        if arm.guard.as_ref().is_some_and(|(_, guard)| contains_let(guard)) {
            return;
        }
        let deleted = self.find(arm.span(), "MatchArm");
        let deleted = deleted.first().map(|&m| format!("!{}", self.selected(m)));
        let Some((_, guard)) = &arm.guard else {
            if let Some(kept) = deleted {
                let end = arm.pat.span().byte_range().end;
                self.edits.push(Edit::insert(end, Order::Guard, format!(" if {kept}")));
            }
            return;
        };
        let mutants = self.find(guard.span(), "MatchArmGuard");
        let mut open = deleted.map_or(String::new(), |kept| format!("{kept} && "));
        for &m in &mutants {
            let selected = self.selected(m);
            open += &match self.mutants[m].replacement.as_str() {
                "true" => format!("({selected} || "),
                _ => format!("(!{selected} && "),
            };
        }
        if !open.is_empty() {
            let span = guard.span().byte_range();
            let close = ")".repeat(mutants.len() + 1);
            self.edits.push(Edit::insert(span.start, Order::Open(self.depth), open + "("));
            self.edits.push(Edit::insert(span.end, Order::Close(-self.depth), close));
        }
    }

    /// A field of `T { field: value, ..rest }` becomes `field: (if .. { (rest).field } else { value })`.
    fn fields(&mut self, e: &syn::ExprStruct) {
        let Some(rest) = &e.rest else { return };
        let rest = &self.source[rest.span().byte_range()];
        for field in &e.fields {
            let mutants = self.find(field.span(), "StructField");
            if mutants.is_empty() {
                continue;
            }
            let name = &self.source[field.member.span().byte_range()];
            let expression = self.expression(&mutants);
            let value = field.expr.span().byte_range();
            let label = if field.colon_token.is_some() { "" } else { &format!("{name}: ") };
            let (open, close) = (Order::Open(self.depth), Order::Close(-self.depth));
            let mut head = Edit::insert(value.start, open, format!("{label}(")).begins(expression);
            self.alternatives(&mut head, &mutants, |_| format!("({rest}).{name}"));
            head.text += "{ ";
            self.edits.push(head);
            self.edits.push(Edit::insert(value.end, close, " })").ends(expression));
        }
    }

    fn constant(&mut self, is_constant: bool, visit: impl FnOnce(&mut Self)) {
        self.constants += usize::from(is_constant);
        visit(self);
        self.constants -= usize::from(is_constant);
    }
}

impl<'ast> Visit<'ast> for Weaver<'_> {
    fn visit_expr(&mut self, e: &'ast syn::Expr) {
        self.depth += 1;
        match e {
            syn::Expr::Binary(binary) => self.binary(binary),
            syn::Expr::Unary(unary) => self.unary(unary),
            syn::Expr::Match(e) => self.match_expression(e),
            _ => {}
        }
        match e {
            // The length is a constant.
            syn::Expr::Repeat(repeat) => self.visit_expr(&repeat.expr),
            // The left side is repeated for each mutant, and has none itself.
            syn::Expr::Binary(binary) if is_assignment(self.operator(binary)) => {
                self.visit_expr(&binary.right);
            }
            _ => visit::visit_expr(self, e),
        }
        self.depth -= 1;
    }

    fn visit_expr_struct(&mut self, e: &'ast syn::ExprStruct) {
        self.fields(e);
        visit::visit_expr_struct(self, e);
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        self.depth += 1;
        self.arm(arm);
        visit::visit_arm(self, arm);
        self.depth -= 1;
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_test(&item.attrs) {
            self.function(&item.sig, &item.block);
            self.constant(item.sig.constness.is_some(), |w| visit::visit_item_fn(w, item));
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.function(&item.sig, &item.block);
        self.constant(item.sig.constness.is_some(), |w| visit::visit_impl_item_fn(w, item));
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.function(&item.sig, block);
        }
        visit::visit_trait_item_fn(self, item);
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.constant(true, |w| visit::visit_item_const(w, item));
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.constant(true, |w| visit::visit_impl_item_const(w, item));
    }

    fn visit_trait_item_const(&mut self, item: &'ast syn::TraitItemConst) {
        self.constant(true, |w| visit::visit_trait_item_const(w, item));
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.constant(true, |w| visit::visit_item_static(w, item));
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_type(&mut self, _: &'ast syn::Type) {}

    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
}

impl Weaver<'_> {
    fn operator(&self, e: &syn::ExprBinary) -> &'static str {
        operator(&self.source[e.op.span().byte_range().start..])
    }
}

/// Returns the binary operator at the beginning of the text.
fn operator(text: &str) -> &'static str {
    // The longest first.
    const OPERATORS: [&str; 28] = [
        "<<=", ">>=", "&&", "||", "==", "!=", "<=", ">=", "+=", "-=", "*=", "/=", "%=", "^=", "&=",
        "|=", "<<", ">>", "+", "-", "*", "/", "%", "^", "&", "|", "<", ">",
    ];
    let operator = OPERATORS.into_iter().find(|operator| text.starts_with(operator));
    operator.expect("a binary operator")
}

fn is_assignment(operator: &str) -> bool {
    operator.ends_with('=') && !matches!(operator, "==" | "!=" | "<=" | ">=")
}

/// Returns whether the conditions of an expression bind names.
fn contains_let(e: &syn::Expr) -> bool {
    struct Found(bool);
    impl<'ast> Visit<'ast> for Found {
        fn visit_expr_let(&mut self, _: &'ast syn::ExprLet) {
            self.0 = true;
        }
        fn visit_expr_closure(&mut self, _: &'ast syn::ExprClosure) {}
        fn visit_block(&mut self, _: &'ast syn::Block) {}
    }
    let mut found = Found(false);
    found.visit_expr(e);
    found.0
}

/// Returns whether the type of the result contains `impl Trait`.
fn returns_impl(signature: &syn::Signature) -> bool {
    struct Found(bool);
    impl<'ast> Visit<'ast> for Found {
        fn visit_type_impl_trait(&mut self, _: &'ast syn::TypeImplTrait) {
            self.0 = true;
        }
    }
    let mut found = Found(false);
    found.visit_return_type(&signature.output);
    found.0
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) if list.path.is_ident("cfg") => {
            list.tokens.to_string().contains("test")
        }
        meta => meta.path().is_ident("test"),
    })
}
