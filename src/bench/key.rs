//! What a render's figures depend on: a stored render is used again where its key is the same, and only there.
//!
//! A setting that is at its default is not in the key, so that renders which are stored stay of use when a setting is
//! added. What makes the same key stand for other figures raises [`VERSION`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::trade::Plan;
use crate::render::RenderOptions;
use crate::training::Training;

/// Of keys. Raise it where a default, or the meaning of a setting, changes: stored renders are then made again.
pub const VERSION: u32 = 6;

/// What a render's figures depend on. Settings are as text: numbers need not survive a file to the last digit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunKey {
    /// [`VERSION`] when it was made.
    pub key_version: u32,
    /// Of Halfway.
    pub version: String,
    /// As [`Context::describe`](crate::device::Context::describe) has it.
    pub device: String,
    pub scene: String,
    /// Of all the scene's data, in hexadecimal.
    pub scene_hash: String,
    /// Of the picture that it was compared with, in hexadecimal.
    pub reference: String,
    /// Pixels.
    pub size: [u32; 2],
    pub camera: usize,
    /// As it is written on the command line: it chooses the seeds.
    pub integrator: String,
    pub seed: u64,
    pub settings: Settings,
}

/// Settings that are not at their defaults, by their names: `training.rounds` is the field `rounds` of the training.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Settings(BTreeMap<String, String>);

impl Settings {
    /// Of a render by a plan. The rest of its options are in [`RunKey`], or are the same for all that benchmarks
    /// render.
    ///
    /// # Errors
    /// Settings that JSON cannot hold; none are known.
    pub fn of(options: &RenderOptions, plan: &Plan) -> Result<Self, serde_json::Error> {
        let default = RenderOptions::default();
        let mut settings = Self::default();
        let method = options.method.descriptor();
        settings.0.insert("method".into(), method.name.into());
        settings.add("method", &options.method, &method.default_method())?;
        settings.add("training", &options.training, &Training::default())?;
        settings.add("max_depth", &options.view.max_depth, &default.view.max_depth)?;
        settings.add("roulette_cap", &options.view.roulette_cap, &default.view.roulette_cap)?;
        settings.add("independent", &options.view.independent, &default.view.independent)?;
        settings.add("plan", plan, &Plan::default())?;
        Ok(settings)
    }

    /// Adds the fields of `value` that differ from those of `default`, their names after `name`.
    fn add<T: Serialize>(&mut self, name: &str, value: &T, default: &T) -> Result<(), serde_json::Error> {
        self.0.extend(differences(name, &serde_json::to_value(value)?, &serde_json::to_value(default)?));
        Ok(())
    }
}

/// Fields of `value` that differ from those of `default`; what only the default has is `none`.
fn differences(name: &str, value: &Value, default: &Value) -> BTreeMap<String, String> {
    let (mut value, default) = (leaves(name, value), leaves(name, default));
    for (field, text) in default {
        if value.get(&field) == Some(&text) {
            value.remove(&field);
        } else {
            value.entry(field).or_insert_with(|| "none".into());
        }
    }
    value
}

/// What stands at the ends of an object's fields, as text, by the fields' names with points between them. What is not
/// there (`null`) is left out.
fn leaves(name: &str, value: &Value) -> BTreeMap<String, String> {
    match value {
        Value::Null => BTreeMap::new(),
        Value::Object(fields) => {
            fields.iter().flat_map(|(field, value)| leaves(&format!("{name}.{field}"), value)).collect()
        }
        _ => BTreeMap::from([(name.to_owned(), value.to_string())]),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use serde_json::json;

    use super::*;
    use crate::bench::trade::Goal;
    use crate::integrator::{METHODS, View};
    use crate::training::When;

    fn key(options: &RenderOptions, plan: &Plan) -> RunKey {
        RunKey {
            key_version: VERSION,
            version: "0.1.0".into(),
            device: "a device".into(),
            scene: "cornell".into(),
            scene_hash: "1".into(),
            reference: "2".into(),
            size: [options.view.width, options.view.height],
            camera: options.camera,
            integrator: options.method.name().into(),
            seed: options.view.seed,
            settings: Settings::of(options, plan).expect("settings as JSON"),
        }
    }

    fn plan() -> Plan {
        let goal = Goal { error: 0.12, longest: Duration::from_millis(2500) };
        Plan { time: Some(Duration::from_secs(1)), equal_samples: 100, goal: Some(goal), ..Plan::default() }
    }

    #[test]
    fn equal_settings_have_equal_keys_after_a_file() {
        // Neither is a sum of few powers of two.
        let options =
            RenderOptions { view: View { roulette_cap: 0.7, ..View::default() }, ..RenderOptions::default() };
        let plan = Plan { goal: plan().goal.map(|goal| Goal { error: 0.1 + 0.2, ..goal }), ..plan() };
        let key = self::key(&options, &plan);
        assert_eq!(key, self::key(&options.clone(), &plan));
        let line = serde_json::to_string(&key).expect("a line");
        assert_eq!(key, serde_json::from_str(&line).expect("a key"));
    }

    #[test]
    fn every_setting_changes_the_key() {
        let default = RenderOptions::default();
        let mut keys = vec![key(&default, &plan())];
        let training = Training::default;
        for options in [
            RenderOptions { view: View { max_depth: Some(6), ..View::default() }, ..default.clone() },
            RenderOptions { view: View { roulette_cap: 0.5, ..View::default() }, ..default.clone() },
            RenderOptions { view: View { seed: 1, ..View::default() }, ..default.clone() },
            RenderOptions { camera: 1, ..default.clone() },
            RenderOptions { view: View { width: 8, ..View::default() }, ..default.clone() },
            RenderOptions { training: training().with_rounds(2), ..default.clone() },
            RenderOptions { training: Training { when: Some(When::First), ..training() }, ..default.clone() },
        ] {
            keys.push(key(&options, &plan()));
        }
        keys.extend(METHODS.iter().skip(1).map(|method| {
            key(&RenderOptions { method: method.default_method(), ..default.clone() }, &plan())
        }));
        for plan in [
            Plan { time: None, ..plan() },
            Plan { time: Some(Duration::from_millis(1001)), ..plan() },
            Plan { samples: Some(8), ..plan() },
            Plan { equal_samples: 64, ..plan() },
            Plan { goal: None, ..plan() },
            Plan { goal: plan().goal.map(|goal| Goal { error: 0.1, ..goal }), ..plan() },
        ] {
            keys.push(key(&default, &plan));
        }
        for (place, key) in keys.iter().enumerate() {
            assert!(!keys[..place].contains(key), "{key:?}");
        }
    }

    /// All values that `value` can become by another value of one of its fields.
    fn neighbours(value: &Value) -> Vec<Value> {
        match value {
            Value::Object(fields) => {
                let with = |(field, value): (&String, &Value)| {
                    let (field, fields) = (field.clone(), fields.clone());
                    neighbours(value).into_iter().map(move |other| {
                        let mut fields = fields.clone();
                        fields.insert(field.clone(), other);
                        Value::Object(fields)
                    })
                };
                fields.iter().flat_map(with).collect()
            }
            Value::Null => vec![json!(1)],
            Value::Bool(value) => vec![json!(!value)],
            Value::Number(_) => vec![json!(123.5), Value::Null],
            _ => vec![json!("another"), Value::Null],
        }
    }

    /// Of those that a method or learning has now, and of those that they will have.
    #[test]
    fn every_field_of_the_settings_is_in_the_key() {
        let mut defaults = vec![serde_json::to_value(Training::default()).expect("JSON")];
        for method in METHODS {
            defaults.push(serde_json::to_value(method.default_method()).expect("JSON"));
        }
        for default in defaults {
            let all = neighbours(&default);
            let keys: Vec<_> = all.iter().map(|value| differences("a", value, &default)).collect();
            assert!(keys.iter().all(|key| key.len() == 1), "{keys:?}");
            for (place, key) in keys.iter().enumerate() {
                assert!(!keys[..place].contains(key), "{key:?}");
            }
        }
    }

    #[test]
    fn an_added_field_at_its_default_changes_no_key() {
        let (value, default) = (json!({ "a": 1, "b": { "c": 2 } }), json!({ "a": 0, "b": { "c": 3 } }));
        let before = differences("training", &value, &default);
        assert_eq!(
            before,
            BTreeMap::from([("training.a", "1"), ("training.b.c", "2")].map(|(a, b)| (a.into(), b.into())))
        );
        for added in [json!(0.5), json!("mm"), json!({ "deep": [1, 2] }), Value::Null] {
            let with = |value: &Value| {
                let mut value = value.clone();
                value["new"] = added.clone();
                value["b"]["new"] = added.clone();
                value
            };
            assert_eq!(differences("training", &with(&value), &with(&default)), before, "{added}");
        }
        let without = json!({ "a": 1, "b": { "c": 2 }, "d": null });
        let default = json!({ "a": 0, "b": { "c": 3 }, "d": 4 });
        assert_eq!(differences("training", &without, &default)["training.d"], "none");
    }

    /// A default is in no key: where one of these fails, raise [`VERSION`], and put the new default here.
    #[test]
    fn defaults_are_those_of_the_version() {
        assert_eq!(VERSION, 6);
        let mut defaults = leaves("training", &serde_json::to_value(Training::default()).expect("JSON"));
        for method in METHODS {
            let value = serde_json::to_value(method.default_method()).expect("JSON");
            defaults.extend(leaves(method.name, &value));
        }
        defaults.insert("roulette_cap".into(), RenderOptions::default().view.roulette_cap.to_string());
        for (name, text) in [
            ("roulette_cap", "0.3"),
            ("training.least_gain", "0.03"),
            ("training.settings.source_share", "0.1"),
            ("training.settings.direction_weight", "0.0"),
            ("training.settings.tree_depth", "15"),
            ("training.settings.lloyd_steps", "5"),
            ("training.settings.light_guide", "true"),
            ("training.settings.tree_stop", "0.99"),
            ("training.settings.tree_samples", "100000"),
            ("training.settings.uniform_share", "0.1"),
            ("training.settings.power_share", "0.02"),
            ("training.settings.max_steps", "20"),
            ("training.settings.held_out", "0.1"),
        ] {
            assert_eq!(defaults.get(name).map(String::as_str), Some(text), "{name}");
        }
        for (method, counts, shares) in
            [("lvcbpt", "[3,3,3]", "[1.0,1.0,1.0,1.0]"), ("spcbpt", "[9,2,1]", "[3.0,2.0,1.0,4.0]")]
        {
            for (field, text) in [("counts", counts), ("shares", shares), ("thinning", "true")] {
                let name = format!("{method}.connections.{field}");
                assert_eq!(defaults.get(&name).map(String::as_str), Some(text), "{name}");
            }
            let adapts = defaults.get(&format!("{method}.connections.adapts"));
            assert_eq!(adapts, Some(&(method == "spcbpt").to_string()), "{method}");
        }
    }
}
