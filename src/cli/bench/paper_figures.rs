//! What the paper measured: Su, Li, Wang, SPCBPT: Subspace-based Probabilistic Connections for Bidirectional Path
//! Tracing, SIGGRAPH 2022, slides, "To achieve MAPE = 12 %" and "100 iterations comparison with record-based method".
//! Seconds on the authors' GPU, pre-processing included. PCBPT is in neither table.

/// What a method took to a MAPE of 12 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    pub seconds: f64,
    /// Of one sample per pixel.
    pub iterations: u32,
}

/// Where a method was after 100 iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AfterHundred {
    pub seconds: f64,
    pub mape: f64,
}

/// A scene.
pub struct Figures {
    pub scene: &'static str,
    /// LVCBPT, RISBPT, SPCBPT.
    seconds: [f64; 3],
    iterations: [u32; 3],
    /// RISBPT, SPCBPT: seconds and per cent.
    after_hundred: [[f64; 2]; 2],
}

const FIGURES: [Figures; 8] = [
    Figures {
        scene: "bedroom",
        seconds: [3182.7, 2136.8, 147.48],
        iterations: [6075, 1407, 171],
        after_hundred: [[149.43, 36.95], [95.12, 14.92]],
    },
    Figures {
        scene: "door",
        seconds: [724.2, 273.4, 35.6],
        iterations: [2328, 269, 59],
        after_hundred: [[100.89, 18.34], [58.34, 9.47]],
    },
    Figures {
        scene: "garden",
        seconds: [756.0, 255.7, 64.5],
        iterations: [2023, 357, 124],
        after_hundred: [[70.99, 19.72], [53.18, 13.01]],
    },
    Figures {
        scene: "hallway",
        seconds: [3295.8, 1983.8, 146.6],
        iterations: [4498, 766, 132],
        after_hundred: [[252.94, 23.45], [112.27, 13.42]],
    },
    Figures {
        scene: "house",
        seconds: [1471.0, 364.2, 80.6],
        iterations: [4741, 550, 150],
        after_hundred: [[65.83, 22.47], [58.70, 14.19]],
    },
    Figures {
        scene: "kitchen",
        seconds: [325.6, 232.9, 134.5],
        iterations: [562, 165, 150],
        after_hundred: [[140.63, 14.87], [90.98, 14.23]],
    },
    Figures {
        scene: "sponza",
        seconds: [599.6, 60.7, 28.8],
        iterations: [1852, 94, 68],
        after_hundred: [[64.54, 11.48], [41.05, 9.94]],
    },
    Figures {
        scene: "diningroom",
        seconds: [4207.5, 569.8, 160.9],
        iterations: [7068, 268, 187],
        after_hundred: [[211.68, 18.18], [88.44, 15.48]],
    },
];

impl Figures {
    /// How many times sooner SPCBPT was there than LVCBPT.
    pub fn speedup(&self) -> f64 {
        self.seconds[0] / self.seconds[2]
    }

    /// Of the method of that name; `None` of one that is not in the table.
    pub fn reached(&self, method: &str) -> Option<Reached> {
        let place = ["lvcbpt", "risbpt", "spcbpt"].iter().position(|other| *other == method)?;
        Some(Reached { seconds: self.seconds[place], iterations: self.iterations[place] })
    }

    /// As [`reached`](Self::reached).
    pub fn after_hundred(&self, method: &str) -> Option<AfterHundred> {
        let place = ["risbpt", "spcbpt"].iter().position(|other| *other == method)?;
        let [seconds, percent] = self.after_hundred[place];
        Some(AfterHundred { seconds, mape: percent / 100.0 })
    }
}

/// The paper's scenes, in its order.
pub fn scenes() -> impl Iterator<Item = &'static str> {
    FIGURES.iter().map(|figures| figures.scene)
}

/// The paper's scene of that name.
pub fn figures(scene: &str) -> Option<&'static Figures> {
    let letters: String = scene.to_lowercase().chars().filter(char::is_ascii_alphabetic).collect();
    // The door of the paper is Veach's, in the edition of Bitterli's collection.
    let letters = letters.replace("veachajar", "door");
    FIGURES.iter().find(|figures| letters.starts_with(figures.scene))
}

#[cfg(test)]
mod tests {
    use super::{FIGURES, figures};

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
            let ratio = figures(scene).expect(scene).speedup();
            assert!((ratio - expected).abs() < 0.06, "{scene}: {ratio}");
        }
        assert!(figures("cornell").is_none());
    }

    /// The two tables agree on what an iteration of RISBPT costs, which has no pre-processing.
    #[test]
    fn the_papers_tables_agree() {
        for scene in &FIGURES {
            let (reached, after) = (scene.reached("risbpt"), scene.after_hundred("risbpt"));
            let (reached, after) = reached.zip(after).expect("both");
            let ratio = 100.0 * reached.seconds / f64::from(reached.iterations) / after.seconds;
            assert!((0.99..1.03).contains(&ratio), "{}: {ratio}", scene.scene);
        }
        assert!(figures("door").and_then(|door| door.reached("pcbpt")).is_none());
    }
}
