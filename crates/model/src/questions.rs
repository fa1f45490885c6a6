//! Questions about the kinds of joints and loads: a row for each, with the kinds that answer it.

/// Methods that return the data of some kinds, and `None` of all others.
macro_rules! data_of_kinds {
    ($kinds:ident: $($(#[$doc:meta])* $name:ident -> $data:ty { $($kind:pat => $value:expr),+ })*) => {
        impl $kinds {
            $($(#[$doc])*
            pub fn $name(&self) -> Option<$data> {
                match *self {
                    $($kind => Some($value),)+
                    _ => None,
                }
            })*
        }
    };
}

/// Methods that are true of some kinds.
macro_rules! sorts_of_kinds {
    ($kinds:ident: $($(#[$doc:meta])* $name:ident { $kind:pat })*) => {
        impl $kinds {
            $($(#[$doc])*
            pub fn $name(&self) -> bool {
                matches!(*self, $kind)
            })*
        }
    };
}

pub(crate) use {data_of_kinds, sorts_of_kinds};
