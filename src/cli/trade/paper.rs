//! What the paper measured: Su, Li, Wang, SPCBPT: Subspace-based Probabilistic Connections for Bidirectional Path Tracing,
//! SIGGRAPH 2022, slides, "To achieve MAPE = 12 %". Seconds on the authors' GPU, pre-processing included.

/// Name of the scene, seconds of LVCBPT, seconds of SPCBPT.
const TO_TWELVE_PERCENT: [(&str, f64, f64); 8] = [
    ("bedroom", 3182.7, 147.48),
    ("door", 724.2, 35.6),
    ("garden", 756.0, 64.5),
    ("hallway", 3295.8, 146.6),
    ("house", 1471.0, 80.6),
    ("kitchen", 325.6, 134.5),
    ("sponza", 599.6, 28.8),
    ("diningroom", 4207.5, 160.9),
];

/// The paper's scene of that name and how many times sooner than LVCBPT SPCBPT met 12 % there.
pub fn speedup(scene: &str) -> Option<(&'static str, f64)> {
    let letters: String = scene.to_lowercase().chars().filter(char::is_ascii_alphabetic).collect();
    // The door of the paper is Veach's, in the edition of Bitterli's collection.
    let letters = letters.replace("veachajar", "door");
    let found = TO_TWELVE_PERCENT.iter().find(|(name, ..)| letters.starts_with(name));
    found.map(|&(name, lvcbpt, spcbpt)| (name, lvcbpt / spcbpt))
}

#[cfg(test)]
mod tests {
    use super::speedup;

    /// The ratios as the paper's text has them.
    #[test]
    fn speedups_of_the_paper() {
        for (scene, expected) in [
            ("bedroom", 21.6),
            ("veach_ajar_diffuse", 20.3),
            ("Garden", 11.7),
            ("hallway", 22.5),
            ("house", 18.3),
            ("kitchen", 2.4),
            ("sponza-night", 20.8),
            ("dining-room", 26.1),
        ] {
            let (_, ratio) = speedup(scene).expect(scene);
            assert!((ratio - expected).abs() < 0.06, "{scene}: {ratio}");
        }
        assert_eq!(speedup("cornell"), None);
    }
}
