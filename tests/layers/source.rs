//! Rust source as far as imports are concerned: the tokens of a file without comments, literals and test code, and the paths in them.

use std::{collections::BTreeMap, fs, path::Path};

/// A path of modules and items below the root of a package; empty for the root itself.
pub type ItemPath = Vec<String>;

/// Identifiers, `::`, and single characters of other punctuation.
pub fn tokens(file: &Path) -> Vec<String> {
    without_tests(tokenized(&fs::read_to_string(file).unwrap()))
}

fn tokenized(text: &str) -> Vec<String> {
    let characters: Vec<char> = text.chars().collect();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let at = |index: usize| characters.get(index).copied().unwrap_or('\0');
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < characters.len() {
        let start = i;
        match at(i) {
            '/' if at(i + 1) == '/' => i = position(&characters, i, |i| at(i) == '\n'),
            '/' if at(i + 1) == '*' => i = position(&characters, i + 2, |i| at(i) == '*' && at(i + 1) == '/') + 2,
            '"' => i = after_string(&characters, i),
            // A character, or a lifetime.
            '\'' if at(i + 1) == '\\' => i = position(&characters, i + 3, |i| at(i) == '\'') + 1,
            '\'' if at(i + 2) == '\'' => i += 3,
            c if is_word(c) => {
                i = position(&characters, i, |i| !is_word(at(i)));
                let word: String = characters[start..i].iter().collect();
                let hashes = position(&characters, i, |i| at(i) != '#') - i;
                if ["r", "br"].contains(&&*word) && at(i + hashes) == '"' {
                    let ends = |end: usize| at(end) == '"' && (1..=hashes).all(|hash| at(end + hash) == '#');
                    i = position(&characters, i + hashes + 1, ends) + hashes + 1;
                } else {
                    tokens.push(word);
                }
            }
            ':' if at(i + 1) == ':' => {
                tokens.push("::".into());
                i += 2;
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(c.into());
                }
                i += 1;
            }
        }
    }
    tokens
}

fn position(characters: &[char], from: usize, found: impl Fn(usize) -> bool) -> usize {
    (from..characters.len()).find(|index| found(*index)).unwrap_or(characters.len())
}

fn after_string(characters: &[char], start: usize) -> usize {
    let mut i = start + 1;
    while i < characters.len() && characters[i] != '"' {
        i += if characters[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// Index behind the bracket that closes the one at `open`.
fn after_bracket(tokens: &[String], open: usize) -> usize {
    let mut depth = 0;
    for (index, token) in tokens.iter().enumerate().skip(open) {
        match &**token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return index + 1;
        }
    }
    tokens.len()
}

/// Removes items with the attribute `#[cfg(test)]`.
fn without_tests(tokens: Vec<String>) -> Vec<String> {
    let mut remaining = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        if tokens[i..].starts_with(&["#", "[", "cfg", "(", "test", ")", "]"].map(String::from)) {
            i += 7;
            while tokens[i] == "#" {
                i = after_bracket(&tokens, i + 1);
            }
            i += tokens[i..].iter().position(|token| token == "{" || token == ";").unwrap();
            i = if tokens[i] == ";" { i + 1 } else { after_bracket(&tokens, i) };
        } else {
            remaining.push(tokens[i].clone());
            i += 1;
        }
    }
    remaining
}

/// All paths that a file refers to, those into its own package resolved from the root: `[package, module, .., item]`.
///
/// `module` is that of the file, `exists` returns whether there is a file of a module. A path that ends in a macro variable is omitted.
pub fn paths(tokens: &[String], package: &str, module: &ItemPath, exists: impl Fn(&ItemPath) -> bool) -> Vec<ItemPath> {
    let scopes = scopes(tokens, module);
    let mut found = Vec::new();
    let mut imported = BTreeMap::new();
    let mut remaining = tokens.to_vec();
    // Imports first: they may follow their uses.
    for start in (0..tokens.len()).filter(|index| tokens[*index] == "use") {
        let end = start + tokens[start..].iter().position(|token| token == ";").unwrap();
        for (path, name) in tree(&tokens[start + 1..end]) {
            let absolute = resolved(&path, package, &scopes[start], &imported, &exists);
            imported.insert(name, absolute.clone());
            found.push(absolute);
        }
        remaining[start..end].fill(";".into());
    }
    for start in 0..remaining.len() {
        let before = start.checked_sub(1).map_or("", |index| &*remaining[index]);
        let is_start = is_identifier(&remaining[start])
            && !["::", "."].contains(&before)
            && (before != "$" || remaining[start] == "crate");
        let path = path_at(&remaining, start);
        if is_start && path.len() > 1 {
            found.push(resolved(&path, package, &scopes[start], &imported, &exists));
        }
    }
    found
}

/// The path that begins at a token; empty where it contains a macro variable.
fn path_at(tokens: &[String], start: usize) -> ItemPath {
    let mut path = vec![tokens[start].clone()];
    let mut separator = start + 1;
    while tokens.get(separator).is_some_and(|token| token == "::") {
        match tokens.get(separator + 1) {
            Some(token) if is_identifier(token) => path.push(token.clone()),
            Some(token) if token == "$" => return Vec::new(),
            _ => break,
        }
        separator += 2;
    }
    path
}

/// The module in which each token is, including those written out in the file.
fn scopes(tokens: &[String], module: &ItemPath) -> Vec<ItemPath> {
    // With the depth of braces inside them.
    let (mut inner, mut depth): (Vec<(String, usize)>, usize) = (Vec::new(), 0);
    let scope = |index: usize| {
        match &*tokens[index] {
            "{" => depth += 1,
            "}" => depth -= 1,
            "mod" if tokens.get(index + 2).is_some_and(|token| token == "{") => {
                inner.push((tokens[index + 1].clone(), depth + 1));
            }
            _ => {}
        }
        if tokens[index] == "}" {
            inner.retain(|(_, inside)| *inside <= depth);
        }
        module.iter().cloned().chain(inner.iter().map(|(name, _)| name.clone())).collect()
    };
    (0..tokens.len()).map(scope).collect()
}

fn is_identifier(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Paths of a `use` tree, each with the name that it brings into scope.
fn tree(tokens: &[String]) -> Vec<(ItemPath, String)> {
    let mut prefix = Vec::new();
    for (index, token) in tokens.iter().enumerate() {
        match &**token {
            "{" => {
                let inside = &tokens[index + 1..tokens.len() - 1];
                let mut found = Vec::new();
                let (mut depth, mut start) = (0, 0);
                for (at, token) in inside.iter().chain([&",".to_owned()]).enumerate() {
                    match &**token {
                        "{" => depth += 1,
                        "}" => depth -= 1,
                        "," if depth == 0 => {
                            found.extend(tree(&inside[start..at]));
                            start = at + 1;
                        }
                        _ => {}
                    }
                }
                return found.into_iter().map(|(path, name)| joined(&prefix, path, name)).collect();
            }
            "as" => return vec![(prefix, tokens[index + 1].clone())],
            "::" | "$" => {}
            _ => prefix.push(token.clone()),
        }
    }
    prefix.last().cloned().map(|name| (prefix, name)).into_iter().collect()
}

fn joined(prefix: &[String], path: ItemPath, name: String) -> (ItemPath, String) {
    if path == ["self"] {
        return (prefix.to_vec(), prefix.last().cloned().unwrap_or(name));
    }
    ([prefix, &path].concat(), name)
}

fn resolved(
    path: &ItemPath,
    package: &str,
    here: &ItemPath,
    imported: &BTreeMap<String, ItemPath>,
    exists: impl Fn(&ItemPath) -> bool,
) -> ItemPath {
    let child = [&here[..], &path[..1]].concat();
    let (base, rest) = match &*path[0] {
        "crate" => (Vec::new(), &path[1..]),
        "self" => (here.clone(), &path[1..]),
        "super" => {
            let levels = path.iter().take_while(|segment| *segment == "super").count();
            (here[..here.len().saturating_sub(levels)].to_vec(), &path[levels..])
        }
        _ if exists(&child) => (here.clone(), &path[..]),
        name => match imported.get(name) {
            Some(absolute) => return [absolute, &path[1..]].concat(),
            None => return path.clone(),
        },
    };
    [&[package.to_owned()], &base[..], rest].concat()
}
