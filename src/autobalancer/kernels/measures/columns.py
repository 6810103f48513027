"""The numbers of a row of measures, in their order: those of the table of measures by name, then what judges the run."""

from __future__ import annotations

COLUMNS = (
    "peak_deflection",
    "peak_speed",
    "peak_time",
    "time_near_peak",
    "time_at_resonance",
    "residual_vibration",
    "static_deflection",
    "vibration",
    "vibration_without_balls",
    "velocity_rms",
    "residual_unbalance",
    "residual_share",
    "support_force",
    "settling_time",
    "settled_at",
    "release_speed",
    "release_time",
    "stalled_time",
    "greatest_ball_speed",
    "impacts",
    "impact_speed",
    "impact_power",
    "greatest_impulse",
    "late_impact_rate",
    "late_impact_power",
    # how the run ended: the stepper's word, time and speed, and what the verdict asks for
    "status",
    "verdict",
    "end_time",
    "end_speed",
    "speed_changes",
    "goes_round",
    "vibration_before",
    "vibration_after",
    "creeps",
    "vibration_to_come",  # change, over its mean at the end
    "settling_since_release",  # settling_time, counted from the last release
)
WIDTH = len(COLUMNS)
(
    PEAK, PEAK_SPEED, PEAK_TIME, NEAR_PEAK, AT_RESONANCE, RESIDUAL, STATIC, VIBRATION, WITHOUT, VELOCITY, LEFT, SHARE, FORCE,
    SETTLING, SETTLED_AT, RELEASE_SPEED, RELEASE_TIME, STALLED, BALL_SPEED,
    IMPACTS, IMPACT_SPEED, IMPACT_POWER, IMPULSE, LATE_RATE, LATE_POWER,
    STATUS, VERDICT, END, END_SPEED, CHANGES, ROUND, BEFORE, AFTER, CREEPS, TO_COME, SINCE_RELEASE,
) = range(WIDTH)  # fmt: skip
