// rigid_body: the projectile's state and its motion, six degrees of freedom.
// Twin: src/physics/rigid_body.rs
//
// A position is held in fixed point, `coarse`·2⁻¹⁰ m + `fine`·2⁻³⁴ m, and the velocity as its change since the impact,
// so that neither a long flight nor a heavy body loses the small steps to rounding. Gaps are measured from the tip of the
// nose, where contact is: from the centre of mass, 20 mm away, a gap rounds to 2e-9 m, which over a time step is 0.01 m/s.

struct Body {
    coarse: vec4<i32>,
    fine: vec4<i32>,
    /// Velocity since the impact [m/s].
    change: vec4<f32>,
    /// Body frame to world, (x, y, z, w).
    orientation: vec4<f32>,
    /// Angular momentum, world frame [kg·m²/s].
    angular_momentum: vec4<f32>,
    /// Velocity [m/s], and in w the bound of the speed of any point.
    velocity: vec4<f32>,
    /// Angular velocity [rad/s].
    turning: vec4<f32>,
    /// The body before the last step.
    coarse_before: vec4<i32>,
    fine_before: vec4<i32>,
    change_before: vec4<f32>,
    /// Impulse on the body since the last sample [N·s].
    impulse: vec4<f32>,
    /// Impulse through held nodes or the drive since the last sample [N·s].
    support: vec4<f32>,
    /// Lost to contact, to friction, work of the drive since the last sample [J]; deepest node so far [m].
    energy: vec4<f32>,
    /// The tip of the nose.
    nose_coarse: vec4<i32>,
    nose_fine: vec4<i32>,
}

/// That of the shot at hand, as it is when a kernel begins.
var<private> body: Body;

/// Steps of `fine` per metre.
const FIXED_POINT_SCALE: f32 = 17179869184.0;

fn rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

/// World to body frame.
fn rotate_back(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> { return rotate(vec4<f32>(-q.xyz, q.w), v); }

/// From the tip of the nose to a node [m]: the large parts are subtracted first.
fn arm_of(coarse: vec4<i32>, fine: vec4<i32>, reference: vec3<f32>, displacement: vec3<f32>) -> vec3<f32> {
    let large = vec3<f32>(coarse.xyz) * (1.0 / 1024.0);
    return ((reference - large) + displacement) - vec3<f32>(fine.xyz) * (1.0 / FIXED_POINT_SCALE);
}

/// From the centre of mass to the tip of the nose [m].
fn nose_of(orientation: vec4<f32>) -> vec3<f32> { return rotate(orientation, vec3<f32>(0.0, 0.0, scene.body_nose)); }

/// Carries what is too much for `fine` over to `coarse`.
fn carry(coarse: vec3<i32>, moved: vec3<i32>) -> vec4<i32> { return vec4<i32>(coarse + (moved >> vec3<u32>(24u)), 0); }

fn remain(moved: vec3<i32>) -> vec4<i32> { return vec4<i32>(moved & vec3<i32>(0xffffff), 0); }

fn angular_velocity(orientation: vec4<f32>, spin: vec3<f32>) -> vec3<f32> {
    let local = rotate_back(orientation, spin);
    return rotate(orientation, local / scene.body_inertia);
}

/// Turns an orientation by the rotation vector θ; series, because a step's angle is small.
fn turned(orientation: vec4<f32>, theta: vec3<f32>) -> vec4<f32> {
    let h = 0.25 * dot(theta, theta);
    // sin(|θ|/2)/|θ| and cos(|θ|/2) in h = |θ|²/4.
    let sine = 0.5 * (1.0 - h / 6.0 * (1.0 - h / 20.0 * (1.0 - h / 42.0)));
    let cosine = 1.0 - 0.5 * h * (1.0 - h / 12.0 * (1.0 - h / 30.0));
    let q = vec4<f32>(sine * theta, cosine);
    let p = orientation;
    return vec4<f32>(q.w * p.xyz + p.w * q.xyz + cross(q.xyz, p.xyz), q.w * p.w - dot(q.xyz, p.xyz));
}

/// An orientation turned about an axis of the body by the angular momentum about it times `rate` [s/(kg·m²)].
fn spun(orientation: vec4<f32>, spin: vec3<f32>, axis: vec3<f32>, rate: f32) -> vec4<f32> {
    let along = dot(rotate_back(orientation, spin), axis);
    return turned(orientation, rotate(orientation, axis * (along * rate)));
}

/// Rotation of the body is free.
fn may_turn() -> bool { return (scene.body_held & 56u) != 56u; }

/// Moves the body through Δt of free flight.
fn advance(start: Body) -> Body {
    var b = start;
    b.velocity = vec4<f32>(shot.impact + b.change.xyz, 0.0);
    let moved = b.fine.xyz + vec3<i32>(round(b.velocity.xyz * scene.dt * FIXED_POINT_SCALE));
    b.coarse = carry(b.coarse.xyz, moved);
    b.fine = remain(moved);
    b.turning = vec4<f32>(0.0);
    if (may_turn()) {
        let inverse = 1.0 / scene.body_inertia;
        let uneven = 0.5 * scene.dt * (inverse.x - inverse.y);
        var q = spun(b.orientation, b.angular_momentum.xyz, vec3<f32>(1.0, 0.0, 0.0), uneven);
        // A symmetric top turns about its axis and, at the same time, about its angular momentum, at constant rates.
        q = spun(q, b.angular_momentum.xyz, vec3<f32>(0.0, 0.0, 1.0), scene.dt * (inverse.z - inverse.y));
        q = turned(q, scene.dt * inverse.y * b.angular_momentum.xyz);
        q = spun(q, b.angular_momentum.xyz, vec3<f32>(1.0, 0.0, 0.0), uneven);
        b.orientation = q / sqrt(dot(q, q));
        b.turning = vec4<f32>(angular_velocity(b.orientation, b.angular_momentum.xyz), 0.0);
    }
    let nose = nose_of(b.orientation);
    let whole = floor(nose * 1024.0);
    let tip = b.fine.xyz + vec3<i32>(round((nose - whole * (1.0 / 1024.0)) * FIXED_POINT_SCALE));
    b.nose_coarse = carry(b.coarse.xyz + vec3<i32>(whole), tip);
    b.nose_fine = remain(tip);
    let turning = sqrt(dot(b.turning.xyz, b.turning.xyz));
    b.velocity.w = sqrt(dot(b.velocity.xyz, b.velocity.xyz)) + turning * scene.body_bounding_radius;
    return b;
}
