//! A small interpreter of AutoLISP: the functions that `bksim.lsp` uses, and a drawing to work on.
//!
//! Variables are dynamic, as in AutoLISP: a function's own ones are put back when it ends. An error calls
//! `*error*` while those of the failing function still stand.

use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

/// A value.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum V {
    Nil,
    T,
    Int(i64),
    Real(f64),
    Str(String),
    Sym(String),
    /// An entity, by its number.
    Ent(usize),
    /// A selection of entities.
    Set(Vec<usize>),
    Cons(Rc<(V, V)>),
    /// Parameters, own variables, body.
    Lambda(Rc<(Vec<String>, Vec<String>, Vec<V>)>),
}

/// An answer of the person at the screen.
#[derive(Clone, Debug)]
pub(crate) enum Answer {
    Pick(usize),
    Text(&'static str),
    Point([f64; 2]),
    Number(i64),
    /// Enter.
    Nothing,
    Cancel,
}

/// An error on its way; `is_told` once `*error*` was called.
#[derive(Debug)]
pub(crate) struct Thrown {
    pub(crate) message: String,
    is_told: bool,
}

pub(crate) type Outcome = Result<V, Thrown>;

pub(crate) fn thrown(message: impl Into<String>) -> Thrown {
    Thrown { message: message.into(), is_told: false }
}

/// The interpreter, the drawing, and the answers that are still to come.
#[derive(Default)]
pub(crate) struct Lisp {
    variables: BTreeMap<String, V>,
    /// The groups of every entity, extended data among them; `None` of one that was erased.
    pub(crate) entities: Vec<Option<V>>,
    pub(crate) answers: VecDeque<Answer>,
    /// The words of `command` and `startapp`.
    pub(crate) commands: Vec<String>,
    pub(crate) printed: String,
    /// The drawing before each group of undoing that was begun.
    pub(crate) undo: Vec<Vec<Option<V>>>,
}

pub(crate) fn list(items: impl IntoIterator<Item = V, IntoIter: DoubleEndedIterator>) -> V {
    items.into_iter().rev().fold(V::Nil, |rest, item| cons(item, rest))
}

pub(crate) fn cons(head: V, tail: V) -> V {
    V::Cons(Rc::new((head, tail)))
}

pub(crate) fn items(value: &V) -> Vec<V> {
    let (mut out, mut rest) = (Vec::new(), value.clone());
    while let V::Cons(pair) = rest {
        out.push(pair.0.clone());
        rest = pair.1.clone();
    }
    out
}

pub(crate) fn head(value: &V) -> V {
    if let V::Cons(pair) = value { pair.0.clone() } else { V::Nil }
}

pub(crate) fn tail(value: &V) -> V {
    if let V::Cons(pair) = value { pair.1.clone() } else { V::Nil }
}

pub(crate) fn text(value: &V) -> Result<&str, Thrown> {
    if let V::Str(text) = value { Ok(text) } else { Err(thrown(format!("no text: {value:?}"))) }
}

fn number(value: &V) -> Result<f64, Thrown> {
    match value {
        V::Int(number) => Ok(*number as f64),
        V::Real(number) => Ok(*number),
        other => Err(thrown(format!("bad argument type: numberp: {other:?}"))),
    }
}

pub(crate) fn index(value: &V) -> Result<usize, Thrown> {
    match value {
        V::Int(number) => usize::try_from(*number).map_err(|_| thrown("a negative index")),
        other => Err(thrown(format!("bad argument type: fixnump: {other:?}"))),
    }
}

fn truth(is_so: bool) -> V {
    if is_so { V::T } else { V::Nil }
}

fn equal(a: &V, b: &V) -> bool {
    match (a, b) {
        (V::Int(_) | V::Real(_), V::Int(_) | V::Real(_)) => number(a).ok() == number(b).ok(),
        _ => a == b,
    }
}

/// All expressions of a text.
pub(crate) fn parse(source: &str) -> Vec<V> {
    let mut letters = source.chars().peekable();
    let mut out = Vec::new();
    while let Some(value) = expression(&mut letters) {
        out.push(value);
    }
    out
}

fn expression(letters: &mut std::iter::Peekable<std::str::Chars<'_>>) -> Option<V> {
    loop {
        match letters.peek()? {
            ';' => {
                letters.by_ref().find(|&c| c == '\n');
            }
            c if c.is_whitespace() => {
                letters.next();
            }
            _ => break,
        }
    }
    match letters.next()? {
        '\'' => Some(list([V::Sym("quote".into()), expression(letters)?])),
        '"' => {
            let mut text = String::new();
            while let Some(c) = letters.next().filter(|&c| c != '"') {
                match c {
                    '\\' => match letters.next()? {
                        'n' => text.push('\n'),
                        other => text.push(other),
                    },
                    c => text.push(c),
                }
            }
            Some(V::Str(text))
        }
        '(' => {
            let mut parts = Vec::new();
            while let Some(part) = expression(letters) {
                if part == V::Sym(")".into()) {
                    return Some(list(parts));
                }
                parts.push(part);
            }
            panic!("a parenthesis is not closed")
        }
        ')' => Some(V::Sym(")".into())),
        first => {
            let mut word = String::from(first);
            while let Some(c) = letters.next_if(|c| !c.is_whitespace() && !"()\";'".contains(*c)) {
                word.push(c);
            }
            let word = word.to_lowercase();
            Some(match word.parse::<i64>() {
                Ok(number) => V::Int(number),
                Err(_) => match word.as_str() {
                    "nil" => V::Nil,
                    "t" => V::T,
                    _ => V::Sym(word),
                },
            })
        }
    }
}

impl Lisp {
    /// Runs a program.
    pub(crate) fn load(&mut self, source: &str) {
        for form in parse(source) {
            self.eval(&form).unwrap_or_else(|error| panic!("{}: {form:?}", error.message));
        }
    }

    /// Runs a command as its name is typed, with these answers.
    pub(crate) fn run(&mut self, command: &str, answers: &[Answer]) -> Outcome {
        self.answers = answers.iter().cloned().collect();
        let outcome = self.eval(&list([V::Sym(format!("c:{}", command.to_lowercase()))]));
        assert!(self.answers.is_empty(), "{command}: not asked for {:?}", self.answers);
        outcome
    }

    pub(crate) fn variable(&self, name: &str) -> V {
        self.variables.get(name).cloned().unwrap_or(V::Nil)
    }

    fn eval(&mut self, form: &V) -> Outcome {
        match form {
            V::Sym(name) => Ok(self.variable(name)),
            V::Cons(pair) => match &pair.0 {
                V::Sym(name) => self.special(name, &pair.1),
                other => {
                    let function = self.eval(other)?;
                    let values = self.values(&pair.1)?;
                    self.apply(&function, &values)
                }
            },
            other => Ok(other.clone()),
        }
    }

    fn body(&mut self, forms: &[V]) -> Outcome {
        forms.iter().try_fold(V::Nil, |_, form| self.eval(form))
    }

    fn values(&mut self, forms: &V) -> Result<Vec<V>, Thrown> {
        items(forms).iter().map(|form| self.eval(form)).collect()
    }

    /// Forms that do not evaluate all of their parts; any other one is a call.
    fn special(&mut self, name: &str, rest: &V) -> Outcome {
        let parts = items(rest);
        match name {
            "quote" => Ok(head(rest)),
            "lambda" => Ok(lambda(&parts[0], &parts[1..])),
            "defun" => {
                let V::Sym(name) = &parts[0] else { return Err(thrown("defun without a name")) };
                self.variables.insert(name.clone(), lambda(&parts[1], &parts[2..]));
                Ok(parts[0].clone())
            }
            "setq" => {
                let mut last = V::Nil;
                for pair in parts.chunks(2) {
                    last = self.eval(&pair[1])?;
                    let V::Sym(name) = &pair[0] else { return Err(thrown("setq of no symbol")) };
                    self.variables.insert(name.clone(), last.clone());
                }
                Ok(last)
            }
            "if" => {
                let branch =
                    if self.eval(&parts[0])? == V::Nil { parts.get(2) } else { parts.get(1) };
                branch.map_or(Ok(V::Nil), |form| self.eval(form))
            }
            "cond" => {
                for clause in parts {
                    let clause = items(&clause);
                    let tested = self.eval(&clause[0])?;
                    if tested != V::Nil {
                        return if clause.len() == 1 {
                            Ok(tested)
                        } else {
                            self.body(&clause[1..])
                        };
                    }
                }
                Ok(V::Nil)
            }
            "progn" => self.body(&parts),
            "while" => {
                for _ in 0..100_000 {
                    if self.eval(&parts[0])? == V::Nil {
                        return Ok(V::Nil);
                    }
                    self.body(&parts[1..])?;
                }
                Err(thrown("an endless loop"))
            }
            "foreach" => {
                let V::Sym(name) = &parts[0] else { return Err(thrown("foreach of no symbol")) };
                let before = self.variable(name);
                for item in items(&self.eval(&parts[1])?) {
                    self.variables.insert(name.clone(), item);
                    self.body(&parts[2..])?;
                }
                self.variables.insert(name.clone(), before);
                Ok(V::Nil)
            }
            "and" => {
                for part in &parts {
                    if self.eval(part)? == V::Nil {
                        return Ok(V::Nil);
                    }
                }
                Ok(V::T)
            }
            "or" => {
                for part in &parts {
                    if self.eval(part)? != V::Nil {
                        return Ok(V::T);
                    }
                }
                Ok(V::Nil)
            }
            _ => {
                let values = self.values(rest)?;
                self.apply(&V::Sym(name.to_owned()), &values)
            }
        }
    }

    fn apply(&mut self, function: &V, values: &[V]) -> Outcome {
        match function {
            V::Lambda(code) => self.call(code, values),
            V::Cons(_) => {
                let function = self.eval(function)?;
                self.apply(&function, values)
            }
            V::Sym(name) => match self.variables.get(name).cloned() {
                Some(V::Lambda(code)) => self.call(&code, values),
                _ => self.builtin(name, values),
            },
            other => Err(thrown(format!("bad function: {other:?}"))),
        }
    }

    fn call(&mut self, code: &(Vec<String>, Vec<String>, Vec<V>), values: &[V]) -> Outcome {
        let (parameters, own, body) = code;
        if parameters.len() != values.len() {
            return Err(thrown(format!("{} arguments for {parameters:?}", values.len())));
        }
        let names = parameters.iter().chain(own);
        let before: Vec<(String, V)> =
            names.map(|name| (name.clone(), self.variable(name))).collect();
        for (name, value) in parameters.iter().zip(values) {
            self.variables.insert(name.clone(), value.clone());
        }
        for name in own {
            self.variables.insert(name.clone(), V::Nil);
        }
        let mut outcome = self.body(body);
        if let Err(error) = &mut outcome
            && !error.is_told
            && own.iter().any(|name| name == "*error*")
        {
            error.is_told = true;
            let message = V::Str(error.message.clone());
            let handler = self.variable("*error*");
            self.apply(&handler, &[message])?;
        }
        self.variables.extend(before);
        outcome
    }

    fn builtin(&mut self, name: &str, values: &[V]) -> Outcome {
        let at = |idx: usize| values.get(idx).cloned().unwrap_or(V::Nil);
        let compare = |is_so: fn(f64, f64) -> bool| -> Outcome {
            Ok(truth(is_so(number(&values[0])?, number(&values[1])?)))
        };
        match name {
            "car" => Ok(head(&at(0))),
            "cdr" => Ok(tail(&at(0))),
            "cadr" => Ok(head(&tail(&at(0)))),
            "cddr" => Ok(tail(&tail(&at(0)))),
            "caddr" => Ok(head(&tail(&tail(&at(0))))),
            "cdddr" => Ok(tail(&tail(&tail(&at(0))))),
            "cons" => Ok(cons(at(0), at(1))),
            "list" => Ok(list(values.to_vec())),
            "append" => Ok(list(values.iter().flat_map(items).collect::<Vec<_>>())),
            "reverse" => Ok(list(items(&at(0)).into_iter().rev().collect::<Vec<_>>())),
            "nth" => Ok(items(&at(1)).get(index(&at(0))?).cloned().unwrap_or(V::Nil)),
            "null" | "not" => Ok(truth(at(0) == V::Nil)),
            "=" | "equal" => Ok(truth(equal(&at(0), &at(1)))),
            "/=" => Ok(truth(!equal(&at(0), &at(1)))),
            "<" => compare(|a, b| a < b),
            "<=" => compare(|a, b| a <= b),
            "1+" | "1-" => match at(0) {
                V::Int(number) => Ok(V::Int(if name == "1+" { number + 1 } else { number - 1 })),
                other => Err(thrown(format!("no integer: {other:?}"))),
            },
            "+" => match (at(0), at(1)) {
                (V::Int(a), V::Int(b)) => Ok(V::Int(a + b)),
                (a, b) => Ok(V::Real(number(&a)? + number(&b)?)),
            },
            "-" => Ok(V::Real(number(&at(0))? - number(&at(1))?)),
            "assoc" => {
                Ok(items(&at(1)).into_iter().find(|it| equal(&head(it), &at(0))).unwrap_or(V::Nil))
            }
            "member" => {
                let mut rest = at(1);
                while rest != V::Nil && !equal(&head(&rest), &at(0)) {
                    rest = tail(&rest);
                }
                Ok(rest)
            }
            "subst" => {
                let new = items(&at(2)).into_iter();
                Ok(list(new.map(|it| if it == at(1) { at(0) } else { it }).collect::<Vec<_>>()))
            }
            "apply" => self.apply(&at(0), &items(&at(1))),
            "mapcar" => {
                let lists: Vec<Vec<V>> = values[1..].iter().map(items).collect();
                let n = lists.iter().map(Vec::len).min().unwrap_or(0);
                let column =
                    |idx: usize| lists.iter().map(|it| it[idx].clone()).collect::<Vec<_>>();
                let mapped: Result<Vec<V>, Thrown> =
                    (0..n).map(|idx| self.apply(&values[0], &column(idx))).collect();
                Ok(list(mapped?))
            }
            "strcat" => Ok(V::Str(values.iter().map(text).collect::<Result<String, _>>()?)),
            "strlen" => {
                Ok(V::Int(i64::try_from(text(&at(0))?.chars().count()).expect("a short text")))
            }
            "strcase" => Ok(V::Str(match at(1) {
                V::Nil => text(&at(0))?.to_uppercase(),
                _ => text(&at(0))?.to_lowercase(),
            })),
            "substr" => {
                // Counted from one.
                let start = index(&at(1))?.checked_sub(1).ok_or_else(|| thrown("substr from 0"))?;
                let length = if at(2) == V::Nil { usize::MAX } else { index(&at(2))? };
                Ok(V::Str(text(&at(0))?.chars().skip(start).take(length).collect()))
            }
            "itoa" => Ok(V::Str(index(&at(0))?.to_string())),
            "princ" => {
                match at(0) {
                    V::Str(text) => self.printed.push_str(&text),
                    V::Nil => (),
                    other => self.printed += format!("{other:?}").as_str(),
                }
                Ok(at(0))
            }
            _ => self.editor(name, values),
        }
    }
}

fn lambda(parameters: &V, body: &[V]) -> V {
    let names: Vec<String> = items(parameters)
        .iter()
        .map(|it| if let V::Sym(name) = it { name.clone() } else { panic!("a parameter: {it:?}") })
        .collect();
    let mut halves = names.split(|name| name == "/");
    let own = |half: Option<&[String]>| half.unwrap_or_default().to_vec();
    let (parameters, locals) = (own(halves.next()), own(halves.next()));
    V::Lambda(Rc::new((parameters, locals, body.to_vec())))
}
