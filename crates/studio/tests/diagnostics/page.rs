//! A page of the diagnostics, taken apart.

/// A page; see the test's description of its sections.
pub(crate) struct Page {
    /// `M005`.
    pub(crate) code: String,
    /// The words after it.
    pub(crate) title: String,
    /// Fault, output and cure, unless the page says *When*.
    pub(crate) example: Option<Example>,
    /// The whole text.
    text: String,
}

/// The three sections of an example.
pub(crate) struct Example {
    /// The files with the fault.
    pub(crate) fault: Vec<Block>,
    /// Commands that are run, and what they print.
    pub(crate) output: Vec<Shown>,
    /// The files without it: whole, or changes (`diff`) of those with it.
    pub(crate) cure: Vec<Block>,
    /// Commands that cure the fault.
    pub(crate) cure_commands: Option<Vec<Shown>>,
}

/// A fenced block that is a file.
pub(crate) struct Block {
    /// The first word of its info string.
    pub(crate) language: String,
    /// The second one; empty in a block of commands.
    pub(crate) file: String,
    /// Text of the block.
    pub(crate) text: String,
}

/// A command and what it prints on stderr.
pub(crate) struct Shown {
    /// The text after `$ `.
    pub(crate) command: String,
    /// The lines below it.
    pub(crate) stderr: String,
}

const FENCE: &str = "```";

impl Page {
    /// Takes a page apart and checks that it has the parts it must have, in their order.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut sections = text.split("\n## ");
        let head = sections.next().unwrap_or_default();
        let (title, introduction) =
            head.split_once("\n\n").ok_or("no paragraph after the title")?;
        let (code, title) = title
            .strip_prefix("# ")
            .and_then(|title| title.split_once(": "))
            .ok_or("the title must be `# CODE: words`")?;
        if introduction.trim().is_empty() || introduction.contains(FENCE) {
            return Err("the title is followed by words alone".into());
        }
        let sections: Vec<(&str, &str)> =
            sections.map(|section| section.split_once('\n').unwrap_or((section, ""))).collect();
        let example = match sections.as_slice() {
            [("When", reason)] => {
                let is_reason = !reason.trim().is_empty() && !reason.contains(FENCE);
                is_reason.then_some(None).ok_or("`When` gives a reason in words")?
            }
            [("Fault", fault), ("Output", output), ("Cure", cure), rest @ ..] => {
                if rest.iter().any(|(_, text)| text.contains("```console")) {
                    return Err("commands outside of Output and Cure".into());
                }
                Some(Example::parse(fault, output, cure)?)
            }
            _ => return Err("sections must be Fault, Output, Cure, …, or When alone".into()),
        };
        Ok(Self { code: code.into(), title: title.into(), example, text: text.into() })
    }

    /// The page with these commands in its section *Output*.
    pub(crate) fn with_output(&self, printed: &[Shown]) -> String {
        let (before, rest) = self.text.split_once("\n## Output").expect("a page with an example");
        let (after, _) = rest.split_once("```console\n").expect("a console block");
        let (_, below) = rest[after.len() + 1..].split_once("\n```\n").expect("its end");
        let shown: String = printed
            .iter()
            .map(|shown| format!("$ {}\n{}", shown.command, shown.stderr))
            .collect::<Vec<_>>()
            .concat();
        format!("{before}\n## Output{after}```console\n{shown}```\n{below}")
    }
}

impl Example {
    fn parse(fault: &str, output: &str, cure: &str) -> Result<Self, String> {
        let (fault, none) = split(blocks(fault)?);
        if fault.is_empty() || !none.is_empty() || fault.iter().any(|b| b.language == "diff") {
            return Err("Fault must hold whole files".into());
        }
        let (none, output) = split(blocks(output)?);
        let [output] = output.as_slice() else { return Err("Output must hold commands".into()) };
        let output = commands(&output.text)?;
        let (cure, cure_commands) = split(blocks(cure)?);
        let cure_commands = match cure_commands.as_slice() {
            [] if cure.is_empty() => return Err("Cure must hold files or commands".into()),
            [] => None,
            [commands_of_cure] => Some(commands(&commands_of_cure.text)?),
            _ => return Err("Cure must hold its commands in one block".into()),
        };
        if !none.is_empty() {
            return Err("Output must hold commands alone".into());
        }
        Ok(Self { fault, output, cure, cure_commands })
    }
}

/// Files, and blocks of commands.
fn split(blocks: Vec<Block>) -> (Vec<Block>, Vec<Block>) {
    blocks.into_iter().partition(|block| block.language != "console")
}

/// The fenced blocks of a section.
fn blocks(section: &str) -> Result<Vec<Block>, String> {
    let mut blocks = Vec::new();
    let mut rest = section;
    while let Some((_, after)) = rest.split_once("\n```") {
        let (info, after) = after.split_once('\n').ok_or("a block without an end")?;
        let (text, after) = after.split_once("```\n").ok_or("a block without an end")?;
        let (language, file) = info.split_once(' ').unwrap_or((info, ""));
        if file.is_empty() != (language == "console") {
            return Err(format!("`{info}` must be `console`, or a language and a file"));
        }
        blocks.push(Block { language: language.into(), file: file.into(), text: text.into() });
        rest = after;
    }
    Ok(blocks)
}

/// The commands of a console block.
fn commands(text: &str) -> Result<Vec<Shown>, String> {
    let mut commands: Vec<Shown> = Vec::new();
    for line in text.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            commands.push(Shown { command: command.into(), stderr: String::new() });
        } else {
            let last = commands.last_mut().ok_or("a console block must begin with `$ `")?;
            last.stderr.push_str(line);
            last.stderr.push('\n');
        }
    }
    if commands.is_empty() { Err("no command".into()) } else { Ok(commands) }
}

/// A text with the lines of `-` replaced by those of `+`; others only say where.
///
/// # Errors
/// What must be there, `-` and kept lines in a row, is not there or is there twice.
pub(crate) fn patched(text: &str, changes: &str) -> Result<String, String> {
    let side = |sign: char| -> Vec<&str> {
        let lines = changes.lines().map(|line| if line.is_empty() { " " } else { line });
        lines.filter(|line| line.starts_with([' ', sign])).map(|line| &line[1..]).collect()
    };
    let (old, new) = (side('-'), side('+'));
    let lines: Vec<&str> = text.lines().collect();
    let starts: Vec<usize> =
        (0..lines.len()).filter(|&start| lines[start..].starts_with(&old)).collect();
    let &[start] = starts.as_slice() else {
        return Err(format!("these lines are there {} times:\n{}", starts.len(), old.join("\n")));
    };
    let parts = [&lines[..start], &new, &lines[start + old.len()..]];
    Ok(parts.concat().iter().map(|line| format!("{line}\n")).collect::<Vec<_>>().concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_replaces_whole_lines_that_are_there_once() {
        let text = "a = 1\nb = 2\nab = 1\n";
        assert_eq!(patched(text, "-b = 2\n+b = 3\n").as_deref(), Ok("a = 1\nb = 3\nab = 1\n"));
        assert_eq!(
            patched(text, " b = 2\n+c = 0\n").as_deref(),
            Ok("a = 1\nb = 2\nc = 0\nab = 1\n")
        );
        assert_eq!(patched(text, "-a = 1\n").as_deref(), Ok("b = 2\nab = 1\n"));
        assert!(patched(text, "-b = 1\n").is_err());
        assert!(patched("a\na\n", "-a\n").is_err());
    }
}
