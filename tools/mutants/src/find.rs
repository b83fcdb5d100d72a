//! Finds the mutants of a file.

use std::collections::HashMap;
use std::ops::Range;

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::mutant::{Edit, Mutant, short};
use crate::operators;

/// Mutants of a file, in the order of the source.
pub fn mutants(file: &str, source: &str) -> syn::Result<Vec<Mutant>> {
    let tree = syn::parse_file(source)?;
    let mut finder = Finder { file, source, scope: Vec::new(), found: Vec::new() };
    finder.visit_file(&tree);
    let mut alike: HashMap<String, usize> = HashMap::new();
    for mutant in &mut finder.found {
        let number = alike.entry(mutant.name()).or_default();
        *number += 1;
        mutant.number = *number;
    }
    Ok(finder.found)
}

struct Finder<'a> {
    file: &'a str,
    source: &'a str,
    /// Types and functions around.
    scope: Vec<String>,
    found: Vec<Mutant>,
}

impl Finder<'_> {
    fn add(&mut self, at: &Range<usize>, operator: &'static str, change: [String; 2], edit: Edit) {
        let line = 1 + self.source[..at.start].matches('\n').count();
        let change = change.map(|text| short(&text));
        let function = self.scope.join("::");
        self.found.push(Mutant { file: self.file.to_owned(), line, function, operator, change, number: 0, edit });
    }

    fn instead(&mut self, expression: &impl Spanned, operator: &'static str, other: String) {
        let range = expression.span().byte_range();
        let original = self.source[range.clone()].to_owned();
        self.add(&range, operator, [original, other.clone()], Edit::Instead { range: range.clone(), other });
    }

    fn text(&self, part: &impl Spanned) -> &str {
        &self.source[part.span().byte_range()]
    }

    fn within(&mut self, name: String, visit: impl FnOnce(&mut Self)) {
        self.scope.push(name);
        visit(self);
        self.scope.pop();
    }

    /// Values that a function with this result may give at once.
    fn give_at_once(&mut self, block: &syn::Block, output: &syn::ReturnType) {
        let values: &[&str] = match output {
            syn::ReturnType::Default => &["()"],
            syn::ReturnType::Type(_, result) => match self.text(result) {
                "bool" => &["true", "false"],
                "f64" => &["0.0", "1.0"],
                "usize" | "u32" | "u64" => &["0", "1"],
                result if result.starts_with("Option<") => &["None"],
                result if result.starts_with("Vec<") => &["Vec::new()"],
                "[f64; 3]" => &["[0.0; 3]"],
                "Vector3<f64>" => &["Vector3::zeros()"],
                "NodeTotals" => &["NodeTotals::default()"],
                _ => &[],
            },
        };
        let at = block.brace_token.span.open().byte_range().end;
        for value in values {
            let edit = Edit::GiveAtOnce { at, value: (*value).to_owned() };
            self.add(&(at..at), "result", ["body".to_owned(), format!("return {value}")], edit);
        }
    }
}

/// Whether something is compiled for tests only.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let is_cfg = attribute.path().is_ident("cfg")
            && matches!(&attribute.meta, syn::Meta::List(list) if list.tokens.to_string() == "test");
        is_cfg || attribute.path().is_ident("test")
    })
}

impl<'a> Visit<'a> for Finder<'_> {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_impl(&mut self, item: &'a syn::ItemImpl) {
        let of = item.trait_.as_ref().map(|(_, path, _)| self.text(path).to_owned());
        // What is printed is no arithmetic.
        if !is_test(&item.attrs) && !of.is_some_and(|of| of.ends_with("Display") || of.ends_with("Debug")) {
            let name = self.text(&item.self_ty).split('<').next().unwrap_or_default().to_owned();
            self.within(name, |finder| visit::visit_item_impl(finder, item));
        }
    }

    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        if !is_test(&item.attrs) && item.sig.constness.is_none() {
            self.within(item.sig.ident.to_string(), |finder| {
                finder.give_at_once(&item.block, &item.sig.output);
                finder.visit_block(&item.block);
            });
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        if !is_test(&item.attrs) && item.sig.constness.is_none() {
            self.within(item.sig.ident.to_string(), |finder| {
                finder.give_at_once(&item.block, &item.sig.output);
                finder.visit_block(&item.block);
            });
        }
    }

    fn visit_item_trait(&mut self, item: &'a syn::ItemTrait) {
        self.within(item.ident.to_string(), |finder| visit::visit_item_trait(finder, item));
    }

    fn visit_trait_item_fn(&mut self, item: &'a syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.within(item.sig.ident.to_string(), |finder| {
                finder.give_at_once(block, &item.sig.output);
                finder.visit_block(block);
            });
        }
    }

    // Constants, types and patterns hold no expression that could change while the program runs.
    fn visit_item_const(&mut self, _: &'a syn::ItemConst) {}
    fn visit_impl_item_const(&mut self, _: &'a syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'a syn::TraitItemConst) {}
    fn visit_item_static(&mut self, _: &'a syn::ItemStatic) {}
    fn visit_item_enum(&mut self, _: &'a syn::ItemEnum) {}
    fn visit_type(&mut self, _: &'a syn::Type) {}
    fn visit_pat(&mut self, _: &'a syn::Pat) {}
    fn visit_generic_argument(&mut self, _: &'a syn::GenericArgument) {}
    fn visit_expr_const(&mut self, _: &'a syn::ExprConst) {}
    fn visit_attribute(&mut self, _: &'a syn::Attribute) {}
    fn visit_expr_repeat(&mut self, repeat: &'a syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_stmt(&mut self, statement: &'a syn::Stmt) {
        if let syn::Stmt::Expr(expression, Some(_)) = statement
            && operators::has_an_effect(expression)
        {
            let range = statement.span().byte_range();
            let text = self.source[range.clone()].to_owned();
            self.add(&range, "statement", [text, String::new()], Edit::LeaveOut(range.clone()));
        }
        visit::visit_stmt(self, statement);
    }

    fn visit_local(&mut self, local: &'a syn::Local) {
        let Some(init) = &local.init else { return };
        self.visit_expr(&init.expr);
        // A block behind `else` must not end, so that nothing in it may be left out.
        if let Some((_, otherwise)) = &init.diverge {
            let found = self.found.len();
            self.visit_expr(otherwise);
            let mut at = 0;
            self.found.retain(|mutant| {
                at += 1;
                at <= found || !matches!(mutant.edit, Edit::LeaveOut(_))
            });
        }
    }

    fn visit_expr(&mut self, expression: &'a syn::Expr) {
        for (operator, other) in operators::others(expression, |part| self.text(part).to_owned()) {
            self.instead(expression, operator, other);
        }
        visit::visit_expr(self, expression);
    }

    fn visit_expr_if(&mut self, conditional: &'a syn::ExprIf) {
        let none = operators::others(&conditional.cond, |part| self.text(part).to_owned()).is_empty();
        if none && operators::is_plain_condition(&conditional.cond) {
            let other = format!("!({})", self.text(&conditional.cond));
            self.instead(&conditional.cond, "condition", other);
        }
        visit::visit_expr_if(self, conditional);
    }

    fn visit_macro(&mut self, call: &'a syn::Macro) {
        // `each!(a in 3 => expression)`; the arguments of `vec!`.
        let name = call.path.segments.last().map(|segment| segment.ident.to_string());
        match name.as_deref() {
            Some("each") => self.visit_tokens(behind_arrow(call.tokens.clone())),
            Some("vec") => self.visit_tokens(call.tokens.clone()),
            _ => {}
        }
    }
}

impl Finder<'_> {
    fn visit_tokens(&mut self, tokens: TokenStream) {
        if let Ok(expression) = syn::parse2::<syn::Expr>(tokens) {
            self.visit_expr(&expression);
        }
    }
}

/// What follows `=>`.
fn behind_arrow(tokens: TokenStream) -> TokenStream {
    let mut before = None;
    let mut rest = tokens.into_iter();
    for token in rest.by_ref() {
        let punctuation = if let TokenTree::Punct(punctuation) = &token { Some(punctuation.as_char()) } else { None };
        if before == Some('=') && punctuation == Some('>') {
            break;
        }
        before = punctuation;
    }
    rest.collect()
}

#[cfg(test)]
mod tests {
    use super::mutants;
    use crate::rewrite::rewrite;

    fn changes(source: &str) -> Vec<String> {
        let found = mutants("a.rs", source).unwrap_or_else(|error| unreachable!("{error}"));
        found.into_iter().map(|mutant| mutant.change.join(" -> ")).collect()
    }

    /// The source with a mutant awake, without brackets and switches: what is written for it in the place of what it stands for.
    fn awake(source: &str, number: usize) -> String {
        let found = mutants("a.rs", source).unwrap_or_else(|error| unreachable!("{error}"));
        let of_file: Vec<_> = found.iter().enumerate().collect();
        let rewritten = rewrite(source, &of_file);
        syn::parse_file(&rewritten.text).unwrap_or_else(|error| unreachable!("{error}: {}", rewritten.text));
        let place = rewritten.places.into_iter().find(|place| place.mutant == number);
        place.map_or(String::new(), |place| rewritten.text[place.own].to_owned())
    }

    #[test]
    fn every_operator_and_constant_is_changed_once_and_tests_are_not() {
        let source = "fn f(a: f64) -> f64 { a + g(2.0) }\n#[cfg(test)]\nmod tests { fn g() -> f64 { 1.0 } }\nconst C: f64 = 1.0 + 1.0;";
        let expected = ["body -> return 0.0", "body -> return 1.0", "a + g(2.0) -> (a) - (g(2.0))", "2.0 -> 4e0"];
        assert_eq!(changes(source), expected);
    }

    #[test]
    fn what_stands_in_a_macro_is_changed_too() {
        let found = changes("fn f(a: [f64; 2]) -> [f64; 2] { each!(i in 2 => a[i] * a[1 - i]) }");
        assert_eq!(found, ["a[i] * a[1 - i] -> (a[i]) / (a[1 - i])", "1 - i -> (1) + (i)", "1 -> 0"]);
    }

    #[test]
    fn mutants_within_mutants_are_rewritten_and_can_be_read() {
        let source = "fn f(a: usize, b: &mut usize) { if a < 3 { *b = a + 1; } *b += 2 * a; }";
        assert_eq!(awake(source, 0), " if crate::mutant::on(0) { return (); }");
        let found = changes(source);
        for (number, change) in found.iter().enumerate().skip(1) {
            let other = change.split(" -> ").nth(1).unwrap_or_default();
            assert!(awake(source, number).contains(other), "{number}: {change}");
        }
        assert!(found.contains(&"*b = a + 1; -> ".to_owned()) && found.contains(&"a < 3 -> (a) <= (3)".to_owned()));
    }

    #[test]
    fn names_stay_when_lines_are_added_elsewhere() {
        let names = |source: &str| {
            let found = mutants("a.rs", source).unwrap_or_else(|error| unreachable!("{error}"));
            found.iter().map(|mutant| mutant.name()).collect::<Vec<_>>()
        };
        let source = "impl A { fn f(a: f64) -> bool { a < 1.0 || a < 1.0 } }";
        assert_eq!(names(&format!("// one line more\n\n{source}")), names(source));
        assert!(names(source).contains(&"a.rs: A::f: `a < 1.0` -> `(a) >= (1.0)` #2".to_owned()));
    }
}
