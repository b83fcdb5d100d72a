//! The mutation operators: what may stand in the place of an expression.

use syn::{BinOp, Expr, Lit, UnOp};

/// What may stand in the place of an expression. `text`: source of a part.
pub fn others(expression: &Expr, text: impl Fn(&Expr) -> String) -> Vec<(&'static str, String)> {
    match expression {
        Expr::Binary(binary) => of_binary(binary, &text),
        Expr::Unary(unary) => match unary.op {
            UnOp::Neg(_) => vec![("negation", in_brackets(text(&unary.expr)))],
            UnOp::Not(_) => vec![("negation", in_brackets(text(&unary.expr)))],
            _ => Vec::new(),
        },
        Expr::Lit(literal) => of_literal(&literal.lit),
        Expr::MethodCall(call) => of_method(call, &text),
        Expr::Call(call) => of_call(call, &text),
        _ => Vec::new(),
    }
}

fn in_brackets(text: String) -> String {
    format!("({text})")
}

fn of_binary(binary: &syn::ExprBinary, text: &impl Fn(&Expr) -> String) -> Vec<(&'static str, String)> {
    let (left, right) = (text(&binary.left), text(&binary.right));
    if is_let_chain(&binary.left) || is_let_chain(&binary.right) {
        return Vec::new();
    }
    let with = |operator: &str| format!("({left}) {operator} ({right})");
    let arithmetic = |operators: &[&str]| operators.iter().map(|o| ("arithmetic", with(o))).collect();
    let comparison = |operators: &[&str]| operators.iter().map(|o| ("comparison", with(o))).collect();
    let logic = |operator: &str| vec![("logic", with(operator))];
    match binary.op {
        BinOp::Add(_) => arithmetic(&["-"]),
        BinOp::Sub(_) => arithmetic(&["+"]),
        BinOp::Mul(_) => arithmetic(&["/"]),
        BinOp::Div(_) => arithmetic(&["*"]),
        BinOp::Rem(_) => arithmetic(&["/"]),
        BinOp::Lt(_) => comparison(&["<=", ">="]),
        BinOp::Le(_) => comparison(&["<", ">"]),
        BinOp::Gt(_) => comparison(&[">=", "<="]),
        BinOp::Ge(_) => comparison(&[">", "<"]),
        BinOp::Eq(_) => comparison(&["!="]),
        BinOp::Ne(_) => comparison(&["=="]),
        BinOp::And(_) => logic("||"),
        BinOp::Or(_) => logic("&&"),
        BinOp::BitAnd(_) => logic("|"),
        BinOp::BitOr(_) => logic("&"),
        BinOp::AddAssign(_) => vec![("arithmetic", format!("{left} -= {right}"))],
        BinOp::SubAssign(_) => vec![("arithmetic", format!("{left} += {right}"))],
        BinOp::MulAssign(_) => vec![("arithmetic", format!("{left} /= {right}"))],
        BinOp::DivAssign(_) => vec![("arithmetic", format!("{left} *= {right}"))],
        BinOp::BitOrAssign(_) => vec![("logic", format!("{left} &= {right}"))],
        BinOp::BitAndAssign(_) => vec![("logic", format!("{left} |= {right}"))],
        _ => Vec::new(),
    }
}

fn is_let_chain(expression: &Expr) -> bool {
    match expression {
        Expr::Let(_) => true,
        Expr::Binary(binary) if matches!(binary.op, BinOp::And(_)) => {
            is_let_chain(&binary.left) || is_let_chain(&binary.right)
        }
        _ => false,
    }
}

fn of_literal(literal: &Lit) -> Vec<(&'static str, String)> {
    let other = match literal {
        Lit::Int(int) => match int.base10_parse::<u64>() {
            Ok(0) => format!("1{}", int.suffix()),
            Ok(value) => format!("{}{}", value - 1, int.suffix()),
            Err(_) => return Vec::new(),
        },
        Lit::Float(float) => match float.base10_parse::<f64>() {
            Ok(0.0) => format!("1.0{}", float.suffix()),
            Ok(1.0) => format!("0.0{}", float.suffix()),
            Ok(value) => format!("{:e}{}", 2.0 * value, float.suffix()),
            Err(_) => return Vec::new(),
        },
        Lit::Bool(value) => (!value.value).to_string(),
        _ => return Vec::new(),
    };
    vec![("constant", other)]
}

fn of_method(call: &syn::ExprMethodCall, text: &impl Fn(&Expr) -> String) -> Vec<(&'static str, String)> {
    let receiver = text(&call.receiver);
    let arguments: Vec<String> = call.args.iter().map(text).collect();
    let all = arguments.join(", ");
    let renamed = |name: &str| format!("({receiver}).{name}({all})");
    match (call.method.to_string().as_str(), arguments.as_slice()) {
        ("min", [_]) => vec![("minmax", renamed("max"))],
        ("max", [_]) => vec![("minmax", renamed("min"))],
        ("lt", [_]) => vec![("comparison", renamed("le")), ("comparison", format!("!({receiver}).lt({all})"))],
        ("le", [_]) => vec![("comparison", renamed("lt")), ("comparison", format!("!({receiver}).le({all})"))],
        ("any", [_]) => vec![("logic", renamed("all"))],
        ("all", [_]) => vec![("logic", renamed("any"))],
        ("floor", []) => vec![("rounding", renamed("ceil"))],
        ("ceil", []) => vec![("rounding", renamed("floor"))],
        ("abs" | "sqrt" | "squared", []) => vec![("call", in_brackets(receiver))],
        ("fused", [factor, term]) => vec![
            ("arithmetic", format!("({receiver}).fused({factor}, -({term}))")),
            ("arithmetic", format!("({receiver}).fused(-({factor}), {term})")),
        ],
        ("clamp", [_, _]) => vec![("call", in_brackets(receiver))],
        ("is_some", []) => vec![("logic", renamed("is_none"))],
        ("is_none", []) => vec![("logic", renamed("is_some"))],
        ("is_some_and" | "is_none_or" | "contains" | "is_empty", _) => {
            vec![("negation", format!("!({receiver}).{}({all})", call.method))]
        }
        ("saturating_sub", [other]) => vec![("arithmetic", format!("({receiver}) + ({other})"))],
        _ => Vec::new(),
    }
}

fn of_call(call: &syn::ExprCall, text: &impl Fn(&Expr) -> String) -> Vec<(&'static str, String)> {
    let function = text(&call.func);
    let arguments: Vec<String> = call.args.iter().map(text).collect();
    match (function.rsplit("::").next(), arguments.as_slice()) {
        (Some("select"), [mask, yes, no]) => vec![("select", format!("{function}({mask}, {no}, {yes})"))],
        _ => Vec::new(),
    }
}

/// Whether leaving a statement out changes what is computed, as far as its form tells.
pub fn has_an_effect(statement: &Expr) -> bool {
    match statement {
        Expr::Assign(_) | Expr::Call(_) | Expr::MethodCall(_) | Expr::Return(_) | Expr::Continue(_) => true,
        Expr::Binary(_) => true,
        _ => false,
    }
}

/// A condition that no other operator changes.
pub fn is_plain_condition(condition: &Expr) -> bool {
    matches!(condition, Expr::Path(_) | Expr::MethodCall(_) | Expr::Call(_) | Expr::Field(_))
}
