//! What became of shots: how many perforated and how many were stopped at each velocity.

/// One shot: what a design has seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Impact velocity, in the unit of all others.
    pub velocity: f64,
    /// Whether the projectile passed.
    pub perforated: bool,
}

/// Shots of one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Impact velocity.
    pub velocity: f64,
    /// Shots that perforated.
    pub perforated: u64,
    /// Shots that were stopped.
    pub stopped: u64,
}

impl Group {
    /// Shots.
    pub fn count(&self) -> u64 {
        self.perforated + self.stopped
    }
}

/// Shots by velocity, ascending; every velocity once, none without a shot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcomes {
    groups: Vec<Group>,
}

impl Outcomes {
    /// Puts shots of the same velocity together.
    pub fn new(groups: impl IntoIterator<Item = Group>) -> Self {
        let mut all: Vec<Group> = groups.into_iter().filter(|group| group.count() > 0).collect();
        all.sort_by(|a, b| a.velocity.total_cmp(&b.velocity));
        all.dedup_by(|next, group| {
            let same = next.velocity == group.velocity;
            if same {
                group.perforated += next.perforated;
                group.stopped += next.stopped;
            }
            same
        });
        Self { groups: all }
    }

    /// The groups, by velocity.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Shots that perforated and that were stopped.
    pub fn counts(&self) -> [u64; 2] {
        let sum = |of: fn(&Group) -> u64| self.groups.iter().map(of).sum();
        [sum(|group| group.perforated), sum(|group| group.stopped)]
    }

    /// Slowest and fastest shot; NaN where there is none.
    pub fn range(&self) -> [f64; 2] {
        [self.groups.first(), self.groups.last()].map(|group| group.map_or(f64::NAN, |group| group.velocity))
    }

    /// Slowest perforation.
    pub fn slowest_perforation(&self) -> Option<f64> {
        self.groups.iter().find(|group| group.perforated > 0).map(|group| group.velocity)
    }

    /// Fastest stop.
    pub fn fastest_stop(&self) -> Option<f64> {
        self.groups.iter().rev().find(|group| group.stopped > 0).map(|group| group.velocity)
    }

    /// Slowest perforation less fastest stop: below zero where results are mixed. `None` where one of the outcomes is missing.
    pub fn gap(&self) -> Option<f64> {
        Some(self.slowest_perforation()? - self.fastest_stop()?)
    }

    /// Whether the fastest stop lies above the slowest perforation. Only then has the likelihood one maximum.
    pub fn overlap(&self) -> bool {
        self.gap().is_some_and(|gap| gap < 0.0)
    }

    /// Mean velocity of perforations and of stops; NaN where there are none.
    pub fn means(&self) -> [f64; 2] {
        let mean = |of: fn(&Group) -> u64| {
            let sum: f64 = self.groups.iter().map(|group| of(group) as f64 * group.velocity).sum();
            sum / self.groups.iter().map(of).sum::<u64>() as f64
        };
        [mean(|group| group.perforated), mean(|group| group.stopped)]
    }
}

impl<'a> FromIterator<&'a Shot> for Outcomes {
    fn from_iter<T: IntoIterator<Item = &'a Shot>>(shots: T) -> Self {
        Self::new(shots.into_iter().map(|shot| {
            let perforated = u64::from(shot.perforated);
            Group { velocity: shot.velocity, perforated, stopped: 1 - perforated }
        }))
    }
}
