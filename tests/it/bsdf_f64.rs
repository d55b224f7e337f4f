//! The BSDF again, in f64 and from the textbook definitions: what `shaders/lib/bsdf.wgsl` is judged by.
//! Local frame, z = shading normal (outside), directions away from the surface.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, DVec4};
use halfway::math::ggx_albedo::GgxAlbedo;
use halfway::scene::{Material, TextureRef};

/// The table both sides read; `c01_albedo_table` judges it.
pub fn albedo_table() -> &'static GgxAlbedo {
    GgxAlbedo::get()
}

/// glTF's parameters after textures, as `SurfaceFactors` of the shader.
#[derive(Clone, Copy, Debug)]
pub struct Factors {
    pub base_color: DVec3,
    pub metallic: f64,
    pub specular_color: DVec3,
    pub specular: f64,
    pub roughness: f64,
    pub transmission: f64,
    pub ior: f64,
    pub volume: bool,
    /// The whole material is a mirror or smooth glass.
    pub delta: bool,
}

impl Factors {
    /// The factors of a material where it has that base colour; `slot` looks a texture up, and is 1 where there is none.
    pub fn at(
        material: &Material,
        base_color: DVec3,
        slot: impl Fn(&Option<TextureRef>, bool) -> DVec4,
    ) -> Self {
        let metallic_roughness = slot(&material.metallic_roughness_texture, false);
        let specular_color = slot(&material.specular_color_texture, true).truncate();
        Self {
            base_color,
            metallic: f64::from(material.metallic) * metallic_roughness.z,
            specular_color: material.specular_color.as_dvec3() * specular_color,
            specular: f64::from(material.specular) * slot(&material.specular_texture, false).w,
            roughness: f64::from(material.roughness) * metallic_roughness.y,
            transmission: f64::from(material.transmission) * slot(&material.transmission_texture, false).x,
            ior: material.ior.into(),
            volume: material.volume,
            delta: material.is_delta(),
        }
    }
}

/// The BSDF at a point.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    base_color: DVec3,
    metallic: f64,
    f0: DVec3,
    f90: f64,
    alpha: f64,
    transmission: f64,
    eta: f64,
    volume: bool,
    pub delta: bool,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub w: DVec3,
    /// Per solid angle; the probability of the event where it is a delta.
    pub pdf: f64,
    /// f |cos w| / pdf.
    pub weight: DVec3,
}

impl Bsdf {
    pub fn new(m: &Factors) -> Self {
        let mut alpha = (m.roughness * m.roughness).max(1e-3);
        let mut eta = m.ior;
        if m.volume && m.transmission > 0.0 && !m.delta {
            eta = eta.max(1.02);
            alpha = alpha.max(2e-4 / (eta - 1.0));
        }
        let normal_incidence = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
        Self {
            base_color: m.base_color,
            metallic: m.metallic,
            f0: (normal_incidence * m.specular_color).min(DVec3::ONE) * m.specular,
            f90: m.specular,
            alpha,
            transmission: m.transmission,
            eta,
            volume: m.volume,
            delta: m.delta,
        }
    }

    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Radiance towards `eye` for radiance from `light`, without the cosine.
    pub fn eval(&self, eye: DVec3, light: DVec3) -> DVec3 {
        if self.delta || eye.z == 0.0 || light.z == 0.0 {
            return DVec3::ZERO;
        }
        let (cos_eye, cos_light) = (eye.z.abs(), light.z.abs());
        let shadowing = 1.0 / (1.0 + self.lambda(eye) + self.lambda(light));
        if eye.z * light.z > 0.0 {
            let h = upward((eye + light).normalize());
            let microfacets = self.distribution(h) * shadowing / (4.0 * cos_eye * cos_light);
            let base = self.base_color * self.diffuse_share() / PI
                * (1.0 - self.interface_albedo(cos_eye))
                * (1.0 - self.interface_albedo(cos_light))
                / (1.0 - self.average_interface_albedo());
            return base + self.reflectance(eye.dot(h).abs(), eye.z) * microfacets;
        }
        let transmittance = |cos: f64| self.transmittance(cos, eye.z);
        if !self.volume {
            let mirrored = DVec3::new(light.x, light.y, -light.z);
            let h = upward((eye + mirrored).normalize());
            let microfacets = self.distribution(h) * shadowing / (4.0 * cos_eye * cos_light);
            return transmittance(eye.dot(h).abs()) * microfacets;
        }
        // Walter et al. 2007, equations 16 and 21: light from i to o.
        let [n_eye, n_light] = self.indices(eye.z);
        let h = upward((n_light * light + n_eye * eye).normalize());
        let (eye_h, light_h) = (eye.dot(h), light.dot(h));
        if eye_h * eye.z <= 0.0 || light_h * light.z <= 0.0 {
            return DVec3::ZERO;
        }
        let jacobian = n_eye * n_eye / (n_light * light_h + n_eye * eye_h).powi(2);
        transmittance(eye_h.abs())
            * (eye_h * light_h / (eye.z * light.z)).abs()
            * (jacobian * shadowing * self.distribution(h))
    }

    /// Density of [`Self::sample`] in solid angle.
    pub fn pdf(&self, from: DVec3, to: DVec3) -> f64 {
        if self.delta || from.z == 0.0 || to.z == 0.0 {
            return 0.0;
        }
        let diffuse = self.diffuse_select(from.z.abs());
        if from.z * to.z > 0.0 {
            let h = upward((from + to).normalize());
            let cos = from.dot(h).abs();
            return diffuse * to.z.abs() / PI
                + (1.0 - diffuse) * self.reflect_select(cos, from.z) * self.visible_normals(from, h)
                    / (4.0 * cos);
        }
        let (h, jacobian) = if self.volume {
            let [n_from, n_to] = self.indices(from.z);
            let h = upward((n_from * from + n_to * to).normalize());
            if from.dot(h) * from.z <= 0.0 || to.dot(h) * to.z <= 0.0 {
                return 0.0;
            }
            // Walter et al. 2007, equation 17.
            (h, n_to * n_to * to.dot(h).abs() / (n_from * from.dot(h) + n_to * to.dot(h)).powi(2))
        } else {
            let h = upward((from + DVec3::new(to.x, to.y, -to.z)).normalize());
            (h, 1.0 / (4.0 * from.dot(h).abs()))
        };
        (1.0 - diffuse)
            * self.transmit_select(from.dot(h).abs(), from.z)
            * self.visible_normals(from, h)
            * jacobian
    }

    /// Draws the direction on the other side of the event; `None` is absorption.
    pub fn sample(&self, from: DVec3, u: [f64; 3], from_eye: bool) -> Option<Sample> {
        let up = DVec3::new(from.x, from.y, from.z.abs());
        let side = from.z.signum();
        let diffuse = if self.delta { 0.0 } else { self.diffuse_select(up.z) };
        if u[2] < diffuse {
            let (r, phi) = (u[0].sqrt(), TAU * u[1]);
            let w = DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt() * side);
            return self.weigh(from, w, from_eye);
        }
        let h = if self.delta { DVec3::Z } else { self.sample_visible_normal(up, u[0], u[1]) };
        let cos = up.dot(h);
        let reflect = self.reflect_select(cos, from.z);
        let transmit = self.transmit_select(cos, from.z);
        if u[2] - diffuse < (1.0 - diffuse) * reflect {
            let w = 2.0 * cos * h - up;
            if w.z <= 0.0 {
                return None;
            }
            let w = DVec3::new(w.x, w.y, w.z * side);
            if self.delta {
                return Some(Sample { w, pdf: reflect, weight: self.reflectance(cos, from.z) / reflect });
            }
            return self.weigh(from, w, from_eye);
        }
        if transmit == 0.0 {
            return None;
        }
        let [n_from, n_to] = if self.volume { self.indices(from.z) } else { [1.0, 1.0] };
        let w = if self.volume || self.delta {
            let ratio = n_from / n_to;
            let cos_t = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
            (ratio * cos - cos_t) * h - ratio * up
        } else {
            (2.0 * cos * h - up) * DVec3::new(1.0, 1.0, -1.0)
        };
        if w.z >= 0.0 {
            return None;
        }
        let w = DVec3::new(w.x, w.y, w.z * side);
        if self.delta {
            let squeeze = if from_eye { (n_from / n_to).powi(2) } else { 1.0 };
            let weight = self.transmittance(cos, from.z) * squeeze / transmit;
            return Some(Sample { w, pdf: transmit, weight });
        }
        self.weigh(from, w, from_eye)
    }

    /// Colour for roulette: a function of the point alone.
    pub fn albedo(&self) -> DVec3 {
        let opaque = self.f0 + (1.0 - self.f0.max_element()) * self.base_color;
        opaque.lerp(self.base_color, self.transmission).lerp(self.base_color, self.metallic)
    }

    fn weigh(&self, from: DVec3, w: DVec3, from_eye: bool) -> Option<Sample> {
        let pdf = self.pdf(from, w);
        let f = if from_eye { self.eval(from, w) } else { self.eval(w, from) };
        (pdf > 0.0).then(|| Sample { w, pdf, weight: f * w.z.abs() / pdf })
    }

    /// Indices of refraction on the side of a direction with this z, and on the other.
    fn indices(&self, z: f64) -> [f64; 2] {
        if z > 0.0 { [1.0, self.eta] } else { [self.eta, 1.0] }
    }

    fn diffuse_share(&self) -> f64 {
        (1.0 - self.metallic) * (1.0 - self.transmission)
    }

    fn interface_albedo(&self, cos: f64) -> f64 {
        let [a, b] = albedo_table().directional(cos, self.alpha);
        self.f0.max_element() * a + self.f90 * b
    }

    fn average_interface_albedo(&self) -> f64 {
        let [a, b] = albedo_table().average(self.alpha);
        self.f0.max_element() * a + self.f90 * b
    }

    /// What a facet reflects, of all layers, at `cos` to its normal, seen from the side of z.
    fn reflectance(&self, cos: f64, z: f64) -> DVec3 {
        let schlick = |f0: DVec3, f90: f64| f0 + (f90 - f0) * (1.0 - cos).powi(5);
        self.metallic * schlick(self.base_color, 1.0)
            + self.diffuse_share() * schlick(self.f0, self.f90)
            + (1.0 - self.metallic) * self.transmission * self.glass_reflectance(cos, z)
    }

    fn transmittance(&self, cos: f64, z: f64) -> DVec3 {
        (1.0 - self.metallic) * self.transmission * (1.0 - self.glass_reflectance(cos, z)) * self.base_color
    }

    fn glass_reflectance(&self, cos: f64, z: f64) -> f64 {
        if self.volume {
            let [n_near, n_far] = self.indices(z);
            return fresnel(cos, n_near, n_far);
        }
        let r = fresnel(cos, 1.0, self.eta);
        2.0 * r / (1.0 + r)
    }

    fn reflect_select(&self, cos: f64, z: f64) -> f64 {
        let (r, t) = (self.reflectance(cos, z).max_element(), self.transmittance(cos, z).max_element());
        if r > 0.0 { r / (r + t) } else { 0.0 }
    }

    fn transmit_select(&self, cos: f64, z: f64) -> f64 {
        if self.transmittance(cos, z).max_element() > 0.0 { 1.0 - self.reflect_select(cos, z) } else { 0.0 }
    }

    fn diffuse_select(&self, cos: f64) -> f64 {
        let [a, b] = albedo_table().directional(cos, self.alpha);
        let interface = self.interface_albedo(cos);
        let base = self.base_color.max_element();
        let diffuse = self.diffuse_share() * base * (1.0 - interface);
        let facets = self.metallic * (base * a + b)
            + self.diffuse_share() * interface
            + (1.0 - self.metallic) * self.transmission;
        if diffuse > 0.0 { diffuse / (diffuse + facets) } else { 0.0 }
    }

    /// D(h) as Walter et al. 2007, equation 33, write it.
    pub fn distribution(&self, h: DVec3) -> f64 {
        let tan_sq = (h.x * h.x + h.y * h.y) / (h.z * h.z);
        let alpha_sq = self.alpha * self.alpha;
        alpha_sq / (PI * h.z.powi(4) * (alpha_sq + tan_sq).powi(2))
    }

    fn lambda(&self, w: DVec3) -> f64 {
        let tan_sq = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tan_sq).sqrt() - 1.0)
    }

    fn visible_normals(&self, w: DVec3, h: DVec3) -> f64 {
        w.dot(h).abs() * self.distribution(h) / ((1.0 + self.lambda(w)) * w.z.abs())
    }

    /// Heitz, Sampling the GGX Distribution of Visible Normals, JCGT 7(4), 2018: another way than the shader's.
    fn sample_visible_normal(&self, w: DVec3, u1: f64, u2: f64) -> DVec3 {
        let v = DVec3::new(self.alpha * w.x, self.alpha * w.y, w.z).normalize();
        let across = DVec3::new(-v.y, v.x, 0.0).try_normalize().unwrap_or(DVec3::X);
        let along = v.cross(across);
        let (r, phi) = (u1.sqrt(), TAU * u2);
        let t1 = r * phi.cos();
        let s = 0.5 * (1.0 + v.z);
        let t2 = (1.0 - s) * (1.0 - t1 * t1).sqrt() + s * r * phi.sin();
        let n = t1 * across + t2 * along + (1.0 - t1 * t1 - t2 * t2).max(0.0).sqrt() * v;
        DVec3::new(self.alpha * n.x, self.alpha * n.y, n.z.max(0.0)).normalize()
    }
}

fn upward(h: DVec3) -> DVec3 {
    if h.z < 0.0 { -h } else { h }
}

/// Fresnel's equations from Snell's law.
pub fn fresnel(cos_near: f64, n_near: f64, n_far: f64) -> f64 {
    let sin_far_sq = (n_near / n_far).powi(2) * (1.0 - cos_near * cos_near);
    if sin_far_sq >= 1.0 {
        return 1.0;
    }
    let cos_far = (1.0 - sin_far_sq).sqrt();
    let perpendicular = (n_near * cos_near - n_far * cos_far) / (n_near * cos_near + n_far * cos_far);
    let parallel = (n_far * cos_near - n_near * cos_far) / (n_far * cos_near + n_near * cos_far);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}
