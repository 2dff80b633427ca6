//! Sections of NASA/TM-1998-208452.

pub const ABSTRACT: &str = "Abstract";
pub const INTRODUCTION: &str = "Introduction";
pub const DATA: &str = "Experimental Data";
pub const STRUCTURE: &str = "Actuator Model Structure";
pub const ESTIMATION: &str = "Parameter Estimation";
pub const APPLICATION: &str = "Application of Parameter Estimation Procedure";
pub const ANALYSIS: &str = "Analysis of BACT Actuator Behavior";
pub const CONCLUSION: &str = "Concluding Remarks";
pub const APPENDIX: &str = "Appendix";
