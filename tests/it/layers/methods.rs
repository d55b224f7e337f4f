//! Who asks which method it is: patterns, found in words and signs.

use super::tokens::{closing, tokens, without_tests};

/// The variants of `enum Method` in the file that declares it; empty in others.
fn variants<'a>(code: &[&'a str]) -> Vec<&'a str> {
    let Some(start) = code.windows(3).position(|words| words == ["enum", "Method", "{"]) else {
        return Vec::new();
    };
    let body = &code[start + 3..closing(code, start + 2)];
    let mut depth = 0;
    let mut found = Vec::new();
    for (at, &word) in body.iter().enumerate() {
        match word {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            _ if depth == 0
                && matches!(at.checked_sub(1).map(|before| body[before]), None | Some("," | "]")) =>
            {
                found.push(word);
            }
            _ => {}
        }
    }
    found
}

/// Where the pattern, with its guard, begins whose `=>` is at `arrow`.
fn arm_start(code: &[&str], arrow: usize) -> usize {
    let mut depth = 0;
    for at in (0..arrow).rev() {
        match code[at] {
            // A block before a pattern is the arm before it, unless the pattern goes on behind it.
            "}" if depth == 0 && !matches!(code[at + 1], "=" | "|" | "if") => return at + 1,
            ")" | "]" | "}" => depth += 1,
            "{" | "(" | "[" if depth == 0 => return at + 1,
            "," if depth == 0 => return at + 1,
            "(" | "[" | "{" => depth -= 1,
            _ => {}
        }
    }
    0
}

/// All patterns of `match`, `let` and `matches!`, and both sides of comparisons as far as one word goes.
fn patterns<'a>(code: &'a [&'a str]) -> Vec<&'a [&'a str]> {
    let mut found = Vec::new();
    for at in 0..code.len() {
        let is = |words: &[&str]| code[at..].starts_with(words);
        if is(&["=", ">"]) {
            found.push(&code[arm_start(code, at)..at]);
        } else if is(&["let"]) {
            let end = code[at..].iter().position(|&word| word == "=" || word == ";" || word == "{");
            let end = end.map_or(code.len(), |end| at + end);
            // A struct's pattern has braces of its own.
            let end = match code.get(end) {
                Some(&"{") => closing(code, end),
                _ => end,
            };
            found.push(&code[at..end]);
        } else if is(&["matches", "!", "("]) {
            let end = closing(code, at + 2);
            let mut depth = 0;
            let comma = code[at + 3..end].iter().position(|&word| {
                depth +=
                    i32::from(matches!(word, "(" | "[" | "{")) - i32::from(matches!(word, ")" | "]" | "}"));
                word == "," && depth == 0
            });
            found.push(&code[comma.map_or(end, |comma| at + 3 + comma)..end]);
        } else if is(&["=", "="]) || is(&["!", "="]) {
            found.push(&code[at + 2..(at + 8).min(code.len())]);
        }
    }
    found
}

/// What of a file asks which method it is, and may not.
pub fn questions(source: &str) -> Vec<String> {
    let all = tokens(source);
    let code = without_tests(&all);
    let own = variants(&code);
    let asks = |pattern: &[&str]| {
        let named = |words: &[&str]| match words {
            ["Method", "::", _] => true,
            ["Self", "::", variant] => own.contains(variant),
            _ => false,
        };
        pattern.windows(3).any(named)
    };
    let renamed = code
        .windows(3)
        .filter(|words| matches!(words, ["Method", "::", "*"]) || words[..2] == ["Method", "as"]);
    let asked = patterns(&code).into_iter().filter(|pattern| asks(pattern)).map(|pattern| pattern.join(" "));
    asked.chain(renamed.map(|words| words.join(" "))).collect()
}

/// Arms for whatever comes: `_` or a name.
pub fn wildcards(source: &str) -> Vec<String> {
    let all = tokens(source);
    let code = without_tests(&all);
    let arrows = (0..code.len()).filter(|&at| code[at..].starts_with(&["=", ">"]));
    arrows
        .filter_map(|at| match code[arm_start(&code, at)..at] {
            [word] if word.starts_with(|c: char| c == '_' || c.is_lowercase()) => Some(word.to_string()),
            _ => None,
        })
        .filter(|word| !matches!(word.as_str(), "true" | "false"))
        .collect()
}

#[test]
fn questions_are_told_from_makings() {
    for asked in [
        "match m { Method::Path => 1, other => { 2 } }",
        "match m { A => { b } Method::Bdpt(x) | Method::Light(x) => x }",
        "match (m, n) { (Some(Method::Path), _) if n => 1 }",
        "if let Method::SpcBpt(x) = m { }",
        "let Method::SpcBpt(SpcBpt { connections, .. }) = m else { return };",
        "matches!(f(a, b), Method::Path | Method::Bdpt(_))",
        "if m == Method::Path { }",
        "use crate::integrator::Method::*;",
        "use crate::integrator::Method as M;",
        "enum Method { Path, #[x] Light(L) } impl Method { fn f(&self) { match self { Self::Light(_) => 1 } } }",
    ] {
        assert!(!questions(asked).is_empty(), "{asked}");
    }
    for made in [
        "let m = Method::SpcBpt(SpcBpt { connections: 1, ..d });",
        "match n { A => Method::Path, B => { Method::Light(l) } C if x => Method::Path }",
        "Settings { method: Method::Path, ..s }; let p = q;",
        "make: |given| Method::Bdpt(Bdpt { light_tracing: given.light_tracing }),",
        "match self { Self::Light => 1 } // Method::Path => 2",
        "match Method::find(name) { Some(found) => found, None => x }",
    ] {
        assert_eq!(questions(made), Vec::<String>::new(), "{made}");
    }
    assert_eq!(
        wildcards("match m { Self::A => 1, _ => 2 } match n { A { b } => { 1 } other => 3 }"),
        ["_", "other"]
    );
    assert_eq!(wildcards("match m { Self::A => 1, Self::B(_) => 2, true => 3 }"), Vec::<String>::new());
}
