//! Declaration of settings: a structure, its defaults and the keys of its fields from one table.

use super::Value;
use serde::Serialize;
use serde::de::value::Error;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;

/// Declares a structure of settings with its defaults, and the keys of its fields in the same order.
///
/// The documentation of a field is the meaning of its key. After the default follow the kind of value, `Words` for an enumeration, and the cases in which
/// the key has an effect, unless it always has one.
macro_rules! declared {
    (
        $(#[doc = $about:literal])+
        pub struct $Settings:ident, $KEYS:ident of $section:literal {
            $(
                #[doc = $meaning:literal]
                $field:ident: $Type:ty = $default:expr, $kind:ident $(($($limit:expr),+))? $(, $cases:ident)?;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub struct $Settings {
            $(
                #[doc = $meaning]
                pub $field: $Type,
            )+
        }

        impl Default for $Settings {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        #[doc = concat!("Keys of [`", stringify!($Settings), "`], in the order of the documentation.")]
        pub(super) static $KEYS: std::sync::LazyLock<Vec<$crate::settings::key::Key>> =
            std::sync::LazyLock::new(|| vec![
                $({
                    let name = $crate::settings::declared::key_name($section, stringify!($field));
                    let meaning = $crate::settings::declared::meaning($meaning);
                    let kind = declared!(@kind $Type, $kind $(($($limit),+))?);
                    $crate::settings::key::key(name, kind, meaning)$(.only_with($cases))?
                },)+
            ]);
    };
    (@kind $Type:ty, Words) => {
        $crate::settings::key::Kind::Words($crate::settings::declared::words::<$Type>())
    };
    (@kind $Type:ty, $kind:ident $(($($limit:expr),+))?) => {
        $crate::settings::key::Kind::$kind $(($($limit),+))?
    };
}
pub(super) use declared;

/// Dotted name of the key of a field.
pub(super) fn key_name(section: &str, field: &str) -> &'static str {
    format!("{section}.{}", field.replace('_', "-")).leak()
}

/// Meaning of a key from the documentation of its field: a phrase without capital and period.
pub(super) fn meaning(documentation: &'static str) -> &'static str {
    let sentence = documentation.trim();
    let phrase = sentence.strip_suffix('.').unwrap_or(sentence);
    let mut letters = phrase.chars();
    match (letters.next(), letters.next()) {
        (Some(first), Some(second)) if first.is_uppercase() && second.is_lowercase() => {
            format!("{}{}", first.to_lowercase(), &phrase[first.len_utf8()..]).leak()
        }
        _ => phrase,
    }
}

/// Sets a field by its name in files; returns false if there is no such field, or if the value is of another kind.
pub(super) fn set_field<T: Serialize + DeserializeOwned>(
    settings: &mut T,
    name: &str,
    value: &Value,
) -> bool {
    let Ok(serde_json::Value::Object(mut fields)) = serde_json::to_value(&*settings) else {
        return false;
    };
    let Some(field) = fields.get_mut(name) else {
        return false;
    };
    *field = match value {
        Value::Number(number) if field.is_u64() => (*number as u64).into(),
        Value::Number(number) => (*number).into(),
        Value::Word(word) => word.as_str().into(),
        Value::Switch(on) => (*on).into(),
        Value::Numbers(numbers) => numbers.as_slice().into(),
        Value::Words(_) => return false,
    };
    let changed = serde_json::from_value(serde_json::Value::Object(fields));
    let is_changed = changed.is_ok();
    if let Ok(changed) = changed {
        *settings = changed;
    }
    is_changed
}

/// Names of the variants of an enumeration in files, in their order.
pub(super) fn words<T: Deserialize<'static>>() -> &'static [&'static str] {
    let mut words: &[&str] = &[];
    // The reader notes the names and refuses to read a value.
    drop(T::deserialize(Names(&mut words)));
    words
}

struct Names<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Names<'_> {
    type Error = Error;

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, Error> {
        *self.0 = variants;
        Err(Error::custom("only the names are read"))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Error> {
        Err(Error::custom("not an enumeration"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq tuple tuple_struct map
        struct identifier ignored_any
    }
}
