//! The mutations of `xtask/mutations.txt`.

use crate::process;

/// A single change that makes the code wrong.
#[derive(Debug)]
pub(super) struct Mutation {
    /// The subject, and what is wrong: `SUBJECT: WRONG`.
    pub(super) name: &'static str,
    /// Cargo's arguments for each target whose tests ought to notice.
    pub(super) targets: Vec<&'static str>,
    /// From the repository's root.
    pub(super) file: &'static str,
    /// A text that stands in the file once.
    from: String,
    /// The text that replaces it.
    to: String,
}

impl Mutation {
    pub(super) fn is_shader(&self) -> bool {
        self.file.starts_with("wgsl/")
    }

    pub(super) fn subject(&self) -> &'static str {
        self.name.split(": ").next().unwrap_or_default()
    }

    /// The file's text with the mutation. It is an error if the old text is not there once, or the new one is the same.
    pub(super) fn mutated(&self) -> Result<String, String> {
        let text = std::fs::read_to_string(process::root().join(self.file)).unwrap_or_default();
        match text.matches(&self.from).count() {
            1 if self.from != self.to => Ok(text.replacen(&self.from, &self.to, 1)),
            count => Err(format!("{}: {} has `{}` {count} times, or keeps it", self.name, self.file, self.from)),
        }
    }
}

/// All mutations of `xtask/mutations.txt`. Mutations of a subject are neighbours.
pub(super) fn all() -> Result<Vec<Mutation>, String> {
    parse(include_str!("../../mutations.txt"))
}

fn parse(text: &'static str) -> Result<Vec<Mutation>, String> {
    let mut mutations = Vec::new();
    for block in text.split("\n= ").skip(1) {
        let mut lines = block.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let (name, file) = lines.next().and_then(|line| line.rsplit_once(" @ ")).unwrap_or_default();
        let mut subjects = text.lines().filter_map(|line| line.strip_prefix("@ ")?.split_once(": "));
        let subject = subjects.find(|(subject, _)| name.split(": ").next() == Some(subject));
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for line in lines {
            match (line.strip_prefix("- "), line.strip_prefix("+ ")) {
                (Some(old), _) if to.is_empty() => from.push(old),
                (_, Some(new)) => to.push(new),
                _ => return Err(format!("{name}: `{line}` is out of place")),
            }
        }
        let targets = subject.ok_or_else(|| format!("`{name}` does not begin with a subject"))?.1.split(", ").collect();
        mutations.push(Mutation { name, targets, file, from: from.join("\n"), to: to.join("\n") });
    }
    mutations.sort_by_key(Mutation::subject);
    Ok(mutations)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each mutation changes the code of today.
    #[test]
    fn every_mutation_fits_the_code_once() {
        let mutations = all().expect("the list is well-formed");
        let wrong: Vec<_> = mutations.iter().filter_map(|mutation| mutation.mutated().err()).collect();
        assert!(mutations.len() > 50, "only {} mutations found", mutations.len());
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    /// Negative controls.
    #[test]
    fn what_does_not_fit_is_noticed() {
        for wrong in ["\n= b: x @ f\n- a", "\n@ a: t\n= a: x @ f\n+ b\n- a", "\n@ a: t\n= a: x @ f\nb"] {
            assert!(parse(wrong).is_err(), "{wrong:?}");
        }
        let text = "# c\n@ a: t, u\n\n= a: x @ Cargo.toml\n- e\n- f\n+ g\n\n# d\n= a: y @ Cargo.toml\n- e\n";
        let two = parse(text).expect("well-formed");
        assert_eq!((&*two[0].targets, &*two[0].from, &*two[0].to, &*two[1].to), (&["t", "u"][..], "e\nf", "g", ""));
        assert!(two.iter().all(|mutation| mutation.mutated().is_err()));
    }
}
