//! The functions of the editor: its drawing, and the person at the screen.

use super::interpreter::{
    Answer, Lisp, Outcome, V, cons, head, index, items, list, tail, text, thrown,
};

impl Lisp {
    /// The functions of the editor.
    pub(crate) fn editor(&mut self, name: &str, values: &[V]) -> Outcome {
        let at = |idx: usize| values.get(idx).cloned().unwrap_or(V::Nil);
        let entity = |value: V| match value {
            V::Ent(idx) => Ok(idx),
            other => Err(thrown(format!("bad argument type: lentityp: {other:?}"))),
        };
        match name {
            "entsel" | "getstring" | "getpoint" | "getint" => self.answer(name),
            "entget" => {
                let idx = entity(at(0))?;
                let groups =
                    self.entities[idx].clone().ok_or_else(|| thrown("an erased entity"))?;
                let is_data = |group: &V| head(group) == V::Int(-3);
                let wanted = items(&at(1));
                let own =
                    items(&groups).into_iter().filter(|it| !is_data(it) || !wanted.is_empty());
                Ok(cons(cons(V::Int(-1), V::Ent(idx)), list(own.collect::<Vec<_>>())))
            }
            "entmod" => {
                let groups = items(&at(0));
                let idx = entity(tail(&groups[0]))?;
                let is_data = |group: &&V| head(group) == V::Int(-3);
                let mut kept: Vec<V> =
                    groups[1..].iter().filter(|it| !is_data(it)).cloned().collect();
                // An application without values has its data removed.
                let data = groups.iter().rev().find(is_data).cloned().unwrap_or(V::Nil);
                if tail(&head(&tail(&data))) != V::Nil {
                    kept.push(data);
                }
                self.entities[idx] = Some(list(kept));
                Ok(at(0))
            }
            "entmake" => {
                self.entities.push(Some(at(0)));
                Ok(at(0))
            }
            "entdel" => {
                self.entities[entity(at(0))?] = None;
                Ok(at(0))
            }
            "ssget" => {
                let filters = items(&at(1));
                let holds = |groups: &V| {
                    let groups = items(groups);
                    filters.iter().all(|filter| {
                        groups.iter().any(|it| {
                            it == filter || head(it) == V::Int(-3) && head(filter) == V::Int(-3)
                        })
                    })
                };
                let found = self.entities.iter().enumerate();
                let found = found.filter(|(_, groups)| groups.as_ref().is_some_and(holds));
                let found: Vec<usize> = found.map(|(idx, _)| idx).collect();
                Ok(if found.is_empty() { V::Nil } else { V::Set(found) })
            }
            "sslength" | "ssname" => {
                let V::Set(set) = at(0) else { return Err(thrown("no selection")) };
                Ok(match name {
                    "sslength" => V::Int(i64::try_from(set.len()).expect("a small selection")),
                    _ => set.get(index(&at(1))?).map_or(V::Nil, |&idx| V::Ent(idx)),
                })
            }
            "command" | "startapp" => {
                let words: Vec<String> = values
                    .iter()
                    .map(|it| text(it).map(str::to_owned))
                    .collect::<Result<_, _>>()?;
                let words = words.join(" ");
                match words.as_str() {
                    "_.UNDO _Begin" => self.undo.push(self.entities.clone()),
                    "_.U" => {
                        self.entities = self.undo.pop().ok_or_else(|| thrown("nothing to undo"))?;
                    }
                    _ => (),
                }
                self.commands.push(words);
                Ok(V::Nil)
            }
            "trans" | "regapp" | "setvar" => Ok(at(0)),
            "getvar" => Ok(match text(&at(0))? {
                "DWGPREFIX" => V::Str("C:\\work\\".into()),
                "DWGNAME" => V::Str("press.dwg".into()),
                _ => V::Real(2.5),
            }),
            other => Err(thrown(format!("no function definition: {other}"))),
        }
    }

    fn answer(&mut self, name: &str) -> Outcome {
        let answer = self.answers.pop_front();
        match (name, answer) {
            (_, Some(Answer::Cancel)) => Err(thrown("Function cancelled")),
            ("entsel", Some(Answer::Pick(idx))) => Ok(list([V::Ent(idx), V::Nil])),
            ("getstring", Some(Answer::Text(text))) => Ok(V::Str(text.to_owned())),
            ("getstring", Some(Answer::Nothing)) => Ok(V::Str(String::new())),
            ("getpoint", Some(Answer::Point([x, y]))) => {
                Ok(list([V::Real(x), V::Real(y), V::Real(0.0)]))
            }
            ("getint", Some(Answer::Number(number))) => Ok(V::Int(number)),
            (_, Some(Answer::Nothing)) => Ok(V::Nil),
            (_, answer) => Err(thrown(format!("{name} is answered by {answer:?}"))),
        }
    }
}
