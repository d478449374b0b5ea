//! The paper's printed figures, as far as they can be compared with numbers: O'Dowd, Studley and Winfield, "The
//! distributed co-evolution of an on-board simulator and controller for swarm robot behaviours", Evolutionary
//! Intelligence 7(2), 2014.

use crate::odowd2014::results::Case;

/// p of Figure 5's t test of a case against Random Movement.
pub(super) fn test(case: Case) -> &'static str {
    match case {
        Case::NoLight => "> 0.5",
        Case::Random => "",
        _ => "< 0.005",
    }
}

/// Number of the figure of a case's genes, and the text's comment on it.
pub(super) fn genes(case: Case) -> Option<(u32, &'static str)> {
    Some(match case {
        Case::NoLight => (
            6,
            "the mean of S0 selects no light throughout, and G0 and G1 spread wide around random search",
        ),
        Case::Over => (
            7,
            "S0 averages around 0.66, between no light and over the nest, G0 goes to positive and G1 to negative \
             phototaxis, and both are narrow",
        ),
        Case::Opposite => (
            8,
            "the mean of S0 selects no light, which is wrong, and G0 and G1 spread wide around random search",
        ),
        Case::OverThenOpposite => (
            9,
            "S0 is right before the light moves and changes slowly after it, without reaching what is right",
        ),
        Case::OppositeThenOver => (
            10,
            "S0 goes towards the border of opposite and no light before the light moves, and responds after it; G0 \
             and G1 spread wide",
        ),
        Case::Random => return None,
    })
}

/// Slips of the paper and the ambiguities they cause.
pub(super) const SLIPS: [&str; 8] = [
    "The first sentence of section 5.5 says that in the case Light Opposite Nest \u{2192} Light Over Nest the light is \
     over the nest first and opposite it then; the case's title and Figure 10 say that it is the other way round.",
    "Section 4.2 installs the best controller as soon as ten are evaluated, after 34 s on average (section 4.3); but in section 4.3 \
     both genotypes change at one transition, the interval's end. The main study takes the latter, and the arm installed-34 the former, with \
     which lagged and matched credit are one rule.",
    "A sentence of section 5.6 is not finished: \u{201c}This supports our hypothesis that .\u{201d}",
    "Figure 5 has bins of 250 s, its t test means of 60 s.",
    "That test has 50 samples, the minutes of the same runs; a swarm continues in one minute what it did in the last, \
     so they are not independent. Tests of runs stand next to it here.",
    "p > 0.5 is read as no difference. A test that finds none does not show that there is none: see claim D1 for the \
     equivalence.",
    "The nest is a circle in section 4.5 and a semi-circle in the caption of Figure 2; the part of the circle that is \
     in the arena is nearly half of it.",
    "Mutations of standard deviation 2, of genes from 0 to 0.99, leave nothing of the parent if what is beyond the \
     ends is folded back, and nearly always give one of both ends if it is cut off. That is why no mutation scale is \
     the paper's here.",
];
