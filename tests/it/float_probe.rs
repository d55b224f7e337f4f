//! What the device's floats do: asserted where WGSL bounds it, printed where WGSL leaves it open.

use crate::gpu;
use crate::random::Stream;

/// The distance of f32 neighbours at `x`.
fn ulp(x: f64) -> f64 {
    let exponent = (x.abs() as f32).to_bits() >> 23;
    2f64.powi(exponent.max(1) as i32 - 127 - 23)
}

fn bits(values: &[[f32; 2]]) -> Vec<[u32; 2]> {
    values.iter().map(|pair| pair.map(f32::to_bits)).collect()
}

/// Largest error of `outputs` against `exact` in units of `unit(exact)`.
fn worst<const O: usize>(
    inputs: &[[f32; 2]],
    outputs: &[[u32; O]],
    column: usize,
    exact: impl Fn(f64, f64) -> f64,
    unit: impl Fn(f64, f64) -> f64,
) -> f64 {
    inputs
        .iter()
        .zip(outputs)
        .map(|(&[x, y], output)| {
            let (x, y) = (f64::from(x), f64::from(y));
            let error = (f64::from(f32::from_bits(output[column])) - exact(x, y)).abs();
            error / unit(x, exact(x, y))
        })
        .fold(0.0, |worst, error| if error <= worst { worst } else { error })
}

#[test]
fn n02_arithmetic_within_wgsl_bounds() {
    let mut random = Stream::new(2);
    // Magnitudes over thirty powers of two either way, both signs.
    let mut number = || {
        let magnitude = (1.0 + random.f32()) * 2f32.powi((random.f32() * 60.0) as i32 - 30);
        if random.word() & 1 == 0 { magnitude } else { -magnitude }
    };
    let inputs: Vec<[f32; 2]> = (0..100_000).map(|_| [number(), number()]).collect();
    let body = "fn twin(x: array<u32, 2>) -> array<u32, 6> {
        let a = bitcast<f32>(x[0]);
        let b = bitcast<f32>(x[1]);
        return array(bitcast<u32>(a + b), bitcast<u32>(a - b), bitcast<u32>(a * b), bitcast<u32>(a / b),
            bitcast<u32>(sqrt(abs(a))), bitcast<u32>(inverseSqrt(abs(a))));
    }";
    let outputs: Vec<[u32; 6]> = gpu::map(&[], body, &bits(&inputs));
    let in_ulp = |_: f64, exact: f64| ulp(exact);
    // WGSL 15.7.4: a correctly rounded result may be either neighbour, hence 1. sqrt is 1 / inverseSqrt.
    type Exact = fn(f64, f64) -> f64;
    let bounds: [(&str, f64, Exact); 6] = [
        ("a + b", 1.0, |a, b| a + b),
        ("a - b", 1.0, |a, b| a - b),
        ("a * b", 1.0, |a, b| a * b),
        ("a / b", 2.5, |a, b| a / b),
        ("sqrt", 4.5, |a, _| a.abs().sqrt()),
        ("inverseSqrt", 2.0, |a, _| 1.0 / a.abs().sqrt()),
    ];
    for (column, (name, bound, exact)) in bounds.into_iter().enumerate() {
        let error = worst(&inputs, &outputs, column, exact, in_ulp);
        println!("{name}: {error:.3} ULP, allowed {bound}");
        assert!(error <= bound, "{name}: {error} ULP instead of {bound}");
    }
}

#[test]
fn n02_functions_within_wgsl_bounds() {
    let mut random = Stream::new(3);
    let pi = std::f32::consts::PI;
    let inputs: Vec<[f32; 2]> = (0..100_000)
        .map(|_| [(2.0 * random.f32() - 1.0) * pi, 2f32.powf(40.0 * random.f32() - 20.0)])
        .collect();
    let body = "fn twin(x: array<u32, 2>) -> array<u32, 6> {
        let a = bitcast<f32>(x[0]);
        let b = bitcast<f32>(x[1]);
        return array(bitcast<u32>(sin(a)), bitcast<u32>(cos(a)), bitcast<u32>(exp(10.0 * a)),
            bitcast<u32>(exp2(10.0 * a)), bitcast<u32>(log(b)), bitcast<u32>(log2(b)));
    }";
    let outputs: Vec<[u32; 6]> = gpu::map(&[], body, &bits(&inputs));
    let logarithm =
        |exact: f64, b: f64| if (0.5..=2.0).contains(&b) { 2f64.powi(-21) } else { 3.0 * ulp(exact) };
    let scale = |x: f64| f64::from(10.0 * x as f32);
    let errors = [
        ("sin", worst(&inputs, &outputs, 0, |a, _| a.sin(), |_, _| 2f64.powi(-11))),
        ("cos", worst(&inputs, &outputs, 1, |a, _| a.cos(), |_, _| 2f64.powi(-11))),
        // The product 10 a is rounded once before.
        (
            "exp",
            worst(&inputs, &outputs, 2, |a, _| scale(a).exp(), |a, e| (3.0 + 2.0 * scale(a).abs()) * ulp(e)),
        ),
        (
            "exp2",
            worst(&inputs, &outputs, 3, |a, _| scale(a).exp2(), |a, e| (3.0 + 2.0 * scale(a).abs()) * ulp(e)),
        ),
        ("log", worst(&inputs, &outputs, 4, |_, b| b.ln(), |_, e| logarithm(e, e.exp()))),
        ("log2", worst(&inputs, &outputs, 5, |_, b| b.log2(), |_, e| logarithm(e, e.exp2()))),
    ];
    for (name, error) in errors {
        println!("{name}: {error:.3} of what is allowed");
        assert!(error <= 1.0, "{name}: {error} times what WGSL allows");
    }
}

/// What the renderer may not rely on: printed, so that a change of driver can be distinguished from a change of code.
#[test]
fn n02_freedoms_of_the_driver() {
    let body = "fn twin(x: array<u32, 4>) -> array<u32, 8> {
        let a = bitcast<f32>(x[0]);
        let b = bitcast<f32>(x[1]);
        let c = bitcast<f32>(x[2]);
        let n = bitcast<f32>(x[3]);
        return array(
            bitcast<u32>(a * b - c), bitcast<u32>((c + b) - c), bitcast<u32>(bitcast<f32>(1u + x[0] * 0u) * 1.0),
            select(0u, 1u, n != n), bitcast<u32>(n - n), bitcast<u32>(min(n, 1.0)),
            bitcast<u32>(clamp(n, 0.0, 1.0)), u32(n));
    }";
    let a = 1.0f32 + f32::EPSILON;
    let b = 1.0 - f32::EPSILON;
    // a * b = 1 - 2^-46 rounds to 1; and 1e-9 is lost in 1e8 + 1e-9.
    let rounded = a * b;
    let first: [u32; 8] = gpu::map(&[], body, &[[a, b, rounded, f32::NAN].map(f32::to_bits)])[0];
    let second: [u32; 8] = gpu::map(&[], body, &[[1.0, 1e-9, 1e8, f32::NAN].map(f32::to_bits)])[0];
    let contracts = f32::from_bits(first[0]) != 0.0;
    let reassociates = f32::from_bits(second[1]) != 0.0;
    println!("device: {}", gpu::context().describe());
    println!("contracts a * b - c: {contracts}; reassociates (c + b) - c: {reassociates}");
    println!("keeps subnormals: {}", first[2] == 1);
    println!("NaN != NaN: {}; NaN - NaN: {}", first[3] == 1, f32::from_bits(first[4]));
    println!(
        "min(NaN, 1): {}; clamp(NaN, 0, 1): {}; u32(NaN): {}",
        f32::from_bits(first[5]),
        f32::from_bits(first[6]),
        first[7]
    );
    // Either answer is lawful, no other one.
    let fused = (f64::from(a) * f64::from(b) - f64::from(rounded)) as f32;
    assert!([0.0, fused].contains(&f32::from_bits(first[0])), "{}", f32::from_bits(first[0]));
    assert!([0.0, 1e-9].contains(&f32::from_bits(second[1])), "{}", f32::from_bits(second[1]));
    assert!(first[2] <= 1, "a subnormal times 1 is itself or 0");
}

#[test]
fn n03_finite_is_a_test_of_bits() {
    let mut random = Stream::new(4);
    let special = [
        f32::NAN.to_bits(),
        (-f32::NAN).to_bits(),
        0x7f80_0001, // a signalling NaN
        0xffff_ffff,
        f32::INFINITY.to_bits(),
        f32::NEG_INFINITY.to_bits(),
        3e38f32.to_bits(),
        f32::MAX.to_bits(),
        f32::MIN.to_bits(),
        0,
        (-0f32).to_bits(),
        1, // the smallest subnormal
        0x007f_ffff,
        f32::MIN_POSITIVE.to_bits(),
        1f32.to_bits(),
    ];
    let mut inputs: Vec<[u32; 3]> = Vec::new();
    for x in special {
        for y in special {
            inputs.push([x, y, 1f32.to_bits()]);
        }
    }
    // Random words, every fourth one among the largest exponents.
    let mut word = || random.word() | if random.word().is_multiple_of(4) { 0x7f80_0000 } else { 0 };
    inputs.extend((0..65_536).map(|_| [word(), word(), word()]));
    let body = "fn twin(x: array<u32, 3>) -> array<u32, 2> {
        let v = vec3f(bitcast<f32>(x[0]), bitcast<f32>(x[1]), bitcast<f32>(x[2]));
        return array(select(0u, 1u, is_finite(v.x)), select(0u, 1u, is_finite3(v)));
    }";
    for (input, output) in inputs.iter().zip(gpu::map(&["lib/math"], body, &inputs)) {
        let finite = input.map(|bits| f32::from_bits(bits).is_finite());
        let expected = [finite[0], finite.iter().all(|finite| *finite)].map(u32::from);
        assert_eq!(output, expected, "{input:08x?}");
    }
}

/// Error-free transforms need a barrier that no compiler sees through: a zero that comes from a buffer.
#[test]
fn n04_a_zero_from_a_buffer_keeps_compensated_sums() {
    let body = "
    fn barrier(x: f32, zero: u32) -> f32 { return bitcast<f32>(bitcast<u32>(x) ^ zero); }
    fn twin(x: array<u32, 3>) -> array<u32, 2> {
        let term = bitcast<f32>(x[0]);
        let zero = x[2];
        var plain = 0.0;
        var sum = 0.0;
        var lost = 0.0;
        for (var i = 0u; i < x[1]; i++) {
            plain += term;
            let corrected = term - lost;
            let next = barrier(sum + corrected, zero);
            lost = barrier(next - sum, zero) - corrected;
            sum = next;
        }
        return array(bitcast<u32>(sum), bitcast<u32>(plain));
    }";
    let output: [u32; 2] = gpu::map(&[], body, &[[0.1f32.to_bits(), 1_000_000, 0]])[0];
    let [sum, plain] = output.map(f32::from_bits);
    println!("1e6 x 0.1: compensated {sum}, plain {plain}");
    assert!((sum - 100_000.0).abs() <= 0.01, "{sum}");
    assert!((plain - 100_000.0).abs() > 100.0, "the plain sum is exact: this test shows nothing");
}
