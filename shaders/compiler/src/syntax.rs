//! Plain words for the mistakes that naga finds while it parses, most of which are habits from other languages.

use crate::explain::{ABSTRACT, alike, conversion};
use crate::words::{is_number, words};

/// Naga's message for a mistake, its notes for the places that belong to it, and where the first of them is.
pub(crate) struct Mistake<'a> {
    pub(crate) message: &'a str,
    pub(crate) labels: &'a [String],
    /// The kernel without comments.
    pub(crate) text: &'a str,
    /// The first place, as a byte of the text.
    pub(crate) at: usize,
    /// The second place as `FILE:LINE:COLUMN`, such as that of a name's first definition.
    pub(crate) other: Option<String>,
}

/// Names that other languages have for types, and a constant of each type.
const TYPES: [(&str, &str); 11] = [
    ("float", "0.0f"),
    ("double", "0.0f"),
    ("f32", "0.0f"),
    ("int", "0"),
    ("i32", "0"),
    ("uint", "0u"),
    ("unsigned", "0u"),
    ("u32", "0u"),
    ("bool", "false"),
    ("auto", "0.0f"),
    ("mut", "0.0f"),
];

impl Mistake<'_> {
    /// What is wrong and what to write instead; else naga's own message, with what its labels add.
    pub(crate) fn explained(&self) -> String {
        self.expected()
            .or_else(|| self.assigned())
            .or_else(|| self.converted())
            .or_else(|| self.redefined())
            .or_else(|| self.argument())
            .or_else(|| self.misused())
            .or_else(|| self.computed())
            .unwrap_or_else(|| self.plain())
    }

    /// Operations on constants without a value, for which naga has a place without a message.
    fn computed(&self) -> Option<String> {
        self.labels.iter().find(|label| *label == "see msg")?;
        let what = self
            .message
            .replace("built-in function argument is out of valid range", "has no value there");
        let what = what.replace(
            "RHS of shift operation is greater than or equal to 32",
            "a shift by 32 bits or more has no value",
        );
        let what = what.replace("Divide operation overflowed", "a division by 0 has no value");
        Some(format!("this is computed of constants, before the kernel runs: {what}"))
    }

    /// Naga's message, without what it says twice.
    fn plain(&self) -> String {
        const EMPTY: [&str; 2] = ["unknown identifier", "invalid accessor"];
        if self.message == "failed to convert expression to a concrete type" {
            return ABSTRACT.to_owned();
        }
        let is_new = |label: &&String| {
            let names = label.strip_prefix("definition of ").unwrap_or(label);
            !EMPTY.contains(&label.as_str()) && !self.message.contains(names)
        };
        let labels: Vec<_> = self.labels.iter().filter(is_new).map(String::as_str).collect();
        if labels.is_empty() {
            return self.message.to_owned();
        }
        format!("{} ({})", self.message, labels.join("; "))
    }

    /// The word that begins at the first place.
    fn word(&self) -> &str {
        let word = words(&self.text[self.at..]).next();
        word.map_or("", |(_, word)| word)
    }

    /// The number that ends at the first place.
    fn before(&self) -> Option<&str> {
        let before = words(&self.text[..self.at]).last();
        before.map(|(_, word)| word).filter(|word| is_number(word))
    }

    /// The word before the first place.
    fn previous(&self) -> &str {
        let before = self.text[..self.at].trim_end();
        let start = before.rfind(|c: char| !c.is_alphanumeric() && c != '_');
        &before[start.map_or(0, |start| start + 1)..]
    }

    /// What was found where WGSL's grammar expects something else.
    fn expected(&self) -> Option<String> {
        let (expected, found) = self.message.split_once(", found ")?;
        let found = found.trim_matches('"');
        let instead = match found {
            "#" => "WGSL has no `#`; write `//` before a comment, and `const NAME = VALUE;` for a `#define`".to_owned(),
            "?" => "WGSL has no `?`; write `select(b, a, condition)` for `condition ? a : b`".to_owned(),
            "F" if let Some(number) = self.before() => {
                format!("the suffix of a float is a small `f`; write `{number}f`")
            }
            "and" => "WGSL has no `and`; write `&&`".to_owned(),
            "or" => "WGSL has no `or`; write `||`".to_owned(),
            _ if ["elif", "elseif", "elsif"].contains(&self.previous()) => {
                format!("WGSL has no `{}`; write `else if`", self.previous())
            }
            _ if expected == "expected `:`" => {
                let previous = self.previous();
                let (_, constant) = TYPES.iter().find(|(ty, _)| *ty == previous)?;
                let ty = match *constant {
                    "0.0f" => "f32",
                    "0" => "i32",
                    "0u" => "u32",
                    _ => "bool",
                };
                format!("`{previous} {found}` declares nothing in WGSL; write `{found}: {ty},`")
            }
            _ if expected == "expected `{`" => {
                format!("a block stands in braces; write `{{` before `{found}` and `}}` after the block")
            }
            _ if expected == "expected variable access" => {
                format!("`{found}` is a type; write `{found}(..)` for a value of it, or the name of a value")
            }
            _ if expected.starts_with("expected global item") => {
                format!("expected a declaration, `fn`, `struct`, `const` or `alias`, found `{found}`")
            }
            _ if expected == "expected assignment or increment/decrement" => {
                let previous = self.previous();
                let (ty, constant) = TYPES.iter().find(|(ty, _)| *ty == previous)?;
                let is_counter = self.text[..self.at]
                    .trim_end()
                    .trim_end_matches(previous)
                    .ends_with('(');
                let constant = if is_counter { "0u" } else { constant };
                format!("`{ty} {found}` declares nothing in WGSL; write `var {found} = {constant};`")
            }
            _ => return None,
        };
        Some(instead)
    }

    /// What can't be assigned to.
    fn assigned(&self) -> Option<String> {
        if !self.message.starts_with("invalid left-hand side of assignment") {
            return None;
        }
        let name = self.word();
        if !self.labels.iter().any(|label| label.contains("immutable")) {
            let (_, component) = self.text[self.at..].split(['=', ';']).next()?.trim().rsplit_once('.')?;
            let is_several = component.len() > 1 && component.chars().all(|c| "xyzwrgba".contains(c));
            return is_several.then(|| {
                format!("several components can't be assigned to at once; write `{name}.x = ..;` and so on, one by one")
            });
        }
        let before = &self.text[..self.at];
        let function = &before[before.rfind("fn ").unwrap_or(0)..];
        let is_let = words(function)
            .zip(words(function).skip(1))
            .any(|((_, one), (_, next))| one == "let" && next == name);
        Some(if is_let {
            format!("`{name}` is declared by `let`, and nothing can be assigned to it; declare it by `var`")
        } else {
            format!("`{name}` is a parameter, and nothing can be assigned to it; copy it: `var next = {name};`")
        })
    }

    /// A value of another type than is needed.
    fn converted(&self) -> Option<String> {
        let types = self
            .message
            .strip_prefix("automatic conversions cannot convert elements of `")?;
        let (found, needed) = types.strip_suffix('`')?.split_once("` to `")?;
        let hint = match self.inferred() {
            Some((name, constant)) if needed == "i32" && found != "bool" => {
                let one = if found == "f32" {
                    format!("{constant}.0f")
                } else {
                    format!("{constant}u")
                };
                format!("; `{name}` is an i32 because of `var {name} = {constant};`: write `{one}` there")
            }
            _ => conversion(found, needed),
        };
        Some(format!("the value is {found}; allowed: {needed}{hint}"))
    }

    /// The variable at the first place and the integer without a suffix that it was declared with, in the same function.
    fn inferred(&self) -> Option<(&str, &str)> {
        let name = self.word();
        let before = &self.text[..self.at];
        let function = &before[before.rfind("fn ").unwrap_or(0)..];
        let (_, value) = function.rsplit_once(&format!("var {name} = "))?;
        let constant = value.split(';').next()?;
        constant.bytes().all(|c| c.is_ascii_digit()).then_some((name, constant))
    }

    /// An argument's type by its labels: `argument #2 has type u32` and the like.
    fn type_of_label(&self, prefix: &str) -> Option<&str> {
        let types = self.labels.iter().filter_map(|label| label.split_once(prefix));
        let (_, ty) = types.into_iter().next()?;
        ty.split([',', '`']).find(|ty| !ty.is_empty())
    }

    /// An argument of one of WGSL's own functions that has a wrong type.
    fn argument(&self) -> Option<String> {
        if self.message.starts_with("type mismatch for reject and accept values") {
            let reject = self.type_of_label("reject value of type ")?;
            let accept = self.type_of_label("accept value of type ")?;
            let hint = alike(reject, accept);
            return Some(format!(
                "`select` chooses between {reject} and {accept}; allowed: one type{hint}"
            ));
        }
        let (kind, rest) = self.message.split_once(" type passed as argument #")?;
        let (number, function) = rest.split_once(" to ")?;
        let found = self.type_of_label(&format!("argument #{number} has type "))?;
        if kind == "inconsistent" {
            let first = self.type_of_label("this argument has type ")?;
            let hint = alike(first, found);
            return Some(format!(
                "argument {number} of {function} is {found}, another is {first}; allowed: one type{hint}"
            ));
        }
        let hint = if found == "bool" {
            "; write `select(0.0f, 1.0f, x)`"
        } else {
            ""
        };
        Some(format!(
            "argument {number} of {function} is {found}; allowed: a number{hint}"
        ))
    }

    /// Other habits that WGSL has no form for, or another.
    fn misused(&self) -> Option<String> {
        let quoted = || self.message.split('`').nth(1);
        Some(
            if self.message.starts_with("name ") && self.message.ends_with(" is a reserved keyword") {
                format!("`{}` is a reserved word of WGSL; choose another name", quoted()?)
            } else if self
                .message
                .starts_with("the operand of the `*` operator must be a pointer")
                && self.text[..self.at].ends_with('*')
            {
                "WGSL has no `**`; write `x * x` for a square".to_owned()
            } else if self.message.starts_with("Float literal is infinite") {
                "a constant is greater than an f32 can be, 3.4028235e38f".to_owned()
            } else if self.message.starts_with("increment/decrement operation requires") {
                format!(
                    "`++` and `--` count u32 or i32; write `{} += 1.0f` for a float",
                    self.word()
                )
            } else if self.message.starts_with("no definition in scope") {
                let name = quoted()?;
                let hint = match name {
                    "True" => "; write `true`",
                    "False" => "; write `false`",
                    "PI" | "M_PI" | "pi" => "; write `3.1415927f`; angles are in turns, of which one is 2 pi",
                    _ => "",
                };
                format!("nothing declares `{name}`{hint}")
            } else if self.message.contains("needs a template argument specified") {
                let ty = quoted()?;
                format!("`{ty}` lacks the type of its components; write `{ty}<f32>`")
            } else if let Some(rest) = self.message.strip_prefix("the type of ") {
                let mut types = rest.split('`').skip(1).step_by(2);
                let (name, needed, found) = (types.next()?, types.next()?, types.next()?);
                let hint = conversion(found, needed);
                format!("`{name}` is declared as {needed}, and its value is {found}{hint}")
            } else if let Some(rest) = self.message.strip_prefix("the concrete type `") {
                let (ty, rest) = rest.split_once('`')?;
                let value = rest.split('`').nth(1)?;
                let range = match ty {
                    "u32" => "; allowed: 0 to 4294967295",
                    "i32" => "; allowed: -2147483648 to 2147483647",
                    _ => "",
                };
                format!("{value} is no {ty}{range}")
            } else {
                return None;
            },
        )
    }

    /// A name that has two definitions.
    fn redefined(&self) -> Option<String> {
        let name = self.message.strip_prefix("redefinition of ")?;
        let other = self.other.as_ref()?;
        Some(format!("{name} is declared at {other} already; choose another name"))
    }
}
