//! Models on disk: whole, or refused with advice.

use halfway::subspace::guide::even_cells;
use halfway::subspace::{FirstConnections, LightGuide, Model, Optimiser, Settings, SubspaceError};

use crate::subspace_data::data;

fn model() -> Model {
    let settings = Settings {
        subspaces: Some(20),
        optimiser: Optimiser::Mirror,
        direction_weight: 0.3,
        smoothing: Some(0.25),
        ..Settings::default()
    };
    let mut model = data(1000, 1).train(&settings);
    model
        .guide
        .get_or_insert_with(|| LightGuide { cells: even_cells(20), picks: vec![0.1; model.sources.len()] });
    // A seed that needs more than 32 bits.
    let first_connections = Some(FirstConnections { count: 15, made: 9, variance: 0.3, cost: 0.4 });
    Model { seed: 1 << 40, first_connections, ..model }
}

/// What reading the file gives when its bytes were changed like that.
fn load(model: &Model, change: impl Fn(&mut Vec<u8>)) -> Result<Model, SubspaceError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.subspaces");
    model.save(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
    Model::load(&path, 7)
}

#[test]
fn models_come_back_as_they_were() {
    let model = model();
    assert_eq!(load(&model, |_| ()).unwrap(), model);
    let automatic = Model { settings: Settings::default(), ..model };
    assert_eq!(load(&automatic, |_| ()).unwrap(), automatic);
}

#[test]
fn models_that_do_not_fit_are_refused() {
    let model = model();
    let other = Model { scene_hash: 8, ..model.clone() };
    assert!(matches!(load(&other, |_| ()), Err(SubspaceError::WrongScene { .. })));
    let newer = load(&model, |bytes| bytes[8] += 1);
    assert!(matches!(newer, Err(SubspaceError::Version { found: 8, expected: 7, .. })));
    let picture = load(&model, |bytes| bytes[..8].copy_from_slice(b"\x89PNG\r\n\x1a\n"));
    assert!(matches!(picture, Err(SubspaceError::NotAModel { .. })));
    assert!(matches!(load(&model, Vec::clear), Err(SubspaceError::NotAModel { .. })));
    let absent = Model::load(std::path::Path::new("/no/such/model"), 7);
    assert!(matches!(absent, Err(SubspaceError::Read { .. })));
}

#[test]
fn models_cut_off_or_damaged_are_refused() {
    let model = model();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole");
    model.save(&path).unwrap();
    let length = std::fs::metadata(&path).unwrap().len() as usize;
    for kept in [8, 11, 20, 35, 36, 37, length / 2, length - 1] {
        let found = load(&model, |bytes| bytes.truncate(kept));
        assert!(matches!(found, Err(SubspaceError::Truncated { .. })), "{kept} of {length} bytes: {found:?}");
    }
    assert!(matches!(load(&model, |bytes| bytes.push(0)), Err(SubspaceError::Damaged { .. })));
    // Any bit: the checksum's own, the hash of the scene, the lists.
    for at in (12..20).chain(28..36).chain((36..length).step_by(997)) {
        let found = load(&model, |bytes| bytes[at] ^= 0x10);
        assert!(matches!(found, Err(SubspaceError::Damaged { .. })), "byte {at}: {found:?}");
    }
    // A sound file of an unsound model.
    for spoil in [
        |model: &mut Model| model.q[3] = 0.0,
        |model: &mut Model| model.gamma[5] += 0.5,
        |model: &mut Model| model.sources[0].first = 20,
        |model: &mut Model| model.gamma.truncate(399),
        |model: &mut Model| model.connections.shares[1] = 0.0,
        |model: &mut Model| model.first_connections.as_mut().expect("a number").count = 65,
        |model: &mut Model| model.guide.as_mut().expect("a guide").cells[70] = 0.0,
    ] {
        let mut spoilt = model.clone();
        spoil(&mut spoilt);
        assert!(matches!(load(&spoilt, |_| ()), Err(SubspaceError::Damaged { .. })));
    }
    for error in [load(&model, |bytes| bytes.truncate(100)), load(&model, |bytes| bytes[8] = 9)] {
        let text = error.unwrap_err().to_string();
        assert!(text.contains("train again"), "{text}");
    }
}
