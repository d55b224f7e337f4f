//! Rust source as words and signs: enough to find paths and patterns in it.

/// Identifiers, `::`, and single signs; comments, strings and characters are left out.
pub fn tokens(source: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = string(rest).or_else(|| character(rest)) {
            length
        } else if is_word(first) {
            let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            found.push(&rest[..end]);
            end
        } else {
            let length = if rest.starts_with("::") { 2 } else { first.len_utf8() };
            if !first.is_whitespace() {
                found.push(&rest[..length]);
            }
            length
        };
        rest = &rest[length..];
    }
    found
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The length of a string that `text` begins with, plain or raw, of bytes or not.
fn string(text: &str) -> Option<usize> {
    let plain = text.strip_prefix('b').unwrap_or(text);
    let prefix = text.len() - plain.len();
    if let Some(inside) = plain.strip_prefix('"') {
        let mut escaped = false;
        for (at, c) in inside.char_indices() {
            match c {
                '"' if !escaped => return Some(prefix + at + 2),
                '\\' => escaped = !escaped,
                _ => escaped = false,
            }
        }
        return Some(text.len());
    }
    let raw = plain.strip_prefix('r')?;
    let hashes = raw.len() - raw.trim_start_matches('#').len();
    let inside = raw[hashes..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(hashes));
    let start = text.len() - inside.len();
    Some(inside.find(&end).map_or(text.len(), |at| start + at + end.len()))
}

/// The length of a character that `text` begins with; of a lifetime that of its quote.
fn character(text: &str) -> Option<usize> {
    let inside = text.strip_prefix('\'')?;
    if let Some(escape) = inside.strip_prefix('\\') {
        // The escaped character may be a quote itself.
        let closing = escape.chars().skip(1).position(|c| c == '\'')?;
        return Some(4 + closing);
    }
    let mut characters = inside.chars();
    let length = characters.next().map_or(0, char::len_utf8);
    Some(if characters.next() == Some('\'') { length + 2 } else { 1 })
}

/// Where the group that begins at `open` ends: the place of its closing bracket, or the end.
pub fn closing(tokens: &[&str], open: usize) -> usize {
    let mut depth = 0;
    for (at, &token) in tokens.iter().enumerate().skip(open) {
        match token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    tokens.len()
}

/// All but the modules of unit tests.
pub fn without_tests<'a>(tokens: &[&'a str]) -> Vec<&'a str> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at..].starts_with(&["#", "[", "cfg", "(", "test", ")", "]", "mod"]) {
            let open = tokens[at..].iter().position(|&token| token == "{" || token == ";");
            let open = open.map_or(tokens.len(), |open| at + open);
            at = closing(tokens, open) + 1;
        } else {
            kept.push(tokens[at]);
            at += 1;
        }
    }
    kept
}

#[test]
fn tokens_are_code_alone() {
    let source = "use a::b; // c::d\nfn f<'a>(x: &'a str) { g('\\'', \"h::i \\\" j\", '/', r#\"k\"l\"#, b\"m\") } /* n */";
    assert_eq!(tokens(source).join(" "), "use a :: b ; fn f < a > ( x : & a str ) { g ( , , , , ) }");
    let code = tokens("a #[cfg(test)] mod tests { b { } } c #[cfg(test)] fn d() {}");
    assert_eq!(without_tests(&code).join(" "), "a c # [ cfg ( test ) ] fn d ( ) { }");
}
