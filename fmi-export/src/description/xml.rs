//! XML of elements with attributes, indented by two spaces.

/// A document under construction.
pub(super) struct Document {
    text: String,
    depth: usize,
}

/// The attributes of an element; those without a value are omitted.
pub(super) type Attributes<'a> = &'a [(&'a str, Option<String>)];

impl Document {
    pub fn new() -> Self {
        Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".into(), depth: 0 }
    }

    /// An element without content.
    pub fn empty(&mut self, name: &str, attributes: Attributes) {
        self.start(name, attributes);
        self.text.push_str("/>\n");
    }

    /// An element with the content that `body` writes.
    pub fn element(&mut self, name: &str, attributes: Attributes, body: impl FnOnce(&mut Self)) {
        self.start(name, attributes);
        self.text.push_str(">\n");
        self.depth += 1;
        body(self);
        self.depth -= 1;
        self.indent();
        self.text.push_str(&format!("</{name}>\n"));
    }

    fn indent(&mut self) {
        self.text.extend(std::iter::repeat_n("  ", self.depth));
    }

    fn start(&mut self, name: &str, attributes: Attributes) {
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        for (name, value) in attributes.iter().filter_map(|(name, value)| Some((name, value.as_ref()?))) {
            self.text.push_str(&format!(" {name}=\"{}\"", escaped(value)));
        }
    }

    pub fn finish(self) -> String {
        self.text
    }
}

/// White space other than blanks is escaped, since readers replace it in attributes; other control characters are not allowed in XML.
fn escaped(value: &str) -> String {
    value.chars().fold(String::new(), |mut text, letter| {
        match letter {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\t' | '\n' | '\r' => text.push_str(&format!("&#{};", letter as u32)),
            letter if letter.is_control() => {}
            letter => text.push(letter),
        }
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_nested_and_what_xml_reserves_is_escaped() {
        let mut document = Document::new();
        document.element("a", &[("b", Some("<\"&\" >\n\u{1}".into())), ("c", None)], |document| {
            document.empty("d", &[]);
        });
        let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
                        <a b=\"&lt;&quot;&amp;&quot; &gt;&#10;\">\n  <d/>\n</a>\n";
        assert_eq!(document.finish(), expected);
    }
}
