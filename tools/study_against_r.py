#!/usr/bin/env python3
"""Runs osteomill study and R side by side on the data sets that come with R's packages.

  study_against_r.py OSTEOMILL

Exit status 77 (skipped) where Rscript is absent; a data set whose package is absent is left out with a message.
R itself writes the tables, so the retyped ones in examples/study/published are checked on the way.
"""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

PUBLISHED = pathlib.Path(__file__).resolve().parent.parent / "examples/study/published"

# Every R block writes table.csv and prints lines "key value"; keys are "name|term|what".
STUDIES = {
    "npk": ("datasets", "npk", """
d <- npk
a <- summary(aov(yield ~ block + N*P*K, d))[[1]]
for (t in c("N", "P", "K", "N:P", "N:K", "P:K")) row("ANOVA in blocks", t, a[trimws(rownames(a)) == t, ])
"""),
    "toothgrowth": ("datasets", "ToothGrowth", """
d <- ToothGrowth
e <- d; e$dose <- factor(e$dose)
a <- anova(lm(len ~ supp*dose, e))
for (t in c("supp", "dose", "supp:dose")) row("ANOVA", t, a[t, ])
w <- t.test(len ~ supp, d); put("Welch t-test", "supp: OJ - VC", "statistic", w$statistic)
put("Welch t-test", "supp: OJ - VC", "df1", w$parameter); put("Welch t-test", "supp: OJ - VC", "p", w$p.value)
r <- resid(lm(len ~ supp*dose, e)); s <- shapiro.test(r * sqrt(10/9))
put("normal residuals (Shapiro-Wilk)", "residuals about exclusive means", "statistic", s$statistic)
put("normal residuals (Shapiro-Wilk)", "residuals about exclusive means", "p", s$p.value)
"""),
    "anorexia": ("MASS", "anorexia", """
d <- MASS::anorexia
m <- lm(Postwt ~ Prewt + Treat, d)
a <- drop1(m, test = "F")
for (t in c("Prewt", "Treat")) { put("ANCOVA", t, "statistic", a[t, "F value"]); put("ANCOVA", t, "p", a[t, "Pr(>F)"]) }
s <- anova(m, lm(Postwt ~ Prewt*Treat, d))
put("ANCOVA, equal slopes", "Prewt:Treat", "statistic", s$F[2]); put("ANCOVA, equal slopes", "Prewt:Treat", "p", s[["Pr(>F)"]][2])
p <- predict(m, data.frame(Treat = levels(d$Treat), Prewt = mean(d$Prewt)), se.fit = TRUE)
for (i in 1:3) { put("adjusted", levels(d$Treat)[i], "mean", p$fit[i]); put("adjusted", levels(d$Treat)[i], "standard_error", p$se.fit[i]) }
"""),
    "orthodont": ("nlme", "Orthodont", """
d <- as.data.frame(nlme::Orthodont)
e <- d; e$age <- factor(e$age); e$Subject <- factor(e$Subject, ordered = FALSE)
a <- summary(aov(distance ~ Sex*age + Error(Subject), e))
row("repeated-measures ANOVA", "Sex", a[[1]][[1]][1, ])
row("repeated-measures ANOVA", "age", a[[2]][[1]][1, ])
row("repeated-measures ANOVA", "Sex:age", a[[2]][[1]][2, ])
"""),
    "sleepstudy": ("lme4", "sleepstudy", """
d <- lme4::sleepstudy
w <- as.matrix(reshape(d, idvar = "Subject", timevar = "Days", direction = "wide")[, -1])
a <- anova(lm(w ~ 1), X = ~1, test = "Spherical")
put("repeated-measures ANOVA", "Days", "statistic", a[1, "F"])
put("repeated-measures ANOVA", "Days", "Greenhouse-Geisser", a[1, "G-G Pr"])
put("repeated-measures ANOVA", "Days", "Huynh-Feldt", a[1, "H-F Pr"])
put("sphericity (Mauchly)", "Days", "statistic", mauchly.test(lm(w ~ 1), X = ~1)$statistic)
v <- as.data.frame(lme4::VarCorr(lme4::lmer(Reaction ~ factor(Days) + (1 | Subject), d)))
put("component", "Subject", "sd", v$sdcor[1]); put("component", "cut (residual)", "sd", v$sdcor[2])
"""),
}
PRELUDE = """
put <- function(name, term, what, value) cat(name, "|", term, "|", what, "|", format(as.numeric(value), digits = 15), "\\n", sep = "")
row <- function(name, term, a) { put(name, term, "statistic", a[["F value"]]); put(name, term, "p", a[["Pr(>F)"]]) }
"""
# An optimiser stops at half the digits; the rest is arithmetic on data of four to seven digits.
TOLERANCE = {"sd": 1e-5}
USUAL = 1e-8


def found(document, name, term, what):
    if name == "adjusted":
        return next(a[what] for a in document["adjusted_means"] if a["group"] == term)
    if name == "component":
        return next(c[what] for c in document["variance_components"] if c["source"] == term)
    for a in document["assumptions"]:
        if a["name"] == name and a["term"] == term:
            return a[what]
    test = next(t for t in document["tests"] if t["name"] == name and t["term"] == term)
    if what in test:
        return test[what]
    return next(c["p"] for c in test["corrections"] if c["name"] == what)


def main():
    osteomill = sys.argv[1]
    if not shutil.which("Rscript"):
        print("skipped: Rscript is absent (Debian: r-base-core r-cran-mass r-cran-nlme r-cran-lme4)")
        return 77
    compared = misses = 0
    for study, (package, data, code) in STUDIES.items():
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "study.R"
            script.write_text(f'if (!requireNamespace("{package}", quietly = TRUE)) quit(status = 77)\n' + PRELUDE + code +
                              f'write.csv(d, "{folder}/table.csv", row.names = FALSE)\n')
            r = subprocess.run(["Rscript", "--vanilla", str(script)], capture_output=True, text=True)
            if r.returncode == 77:
                print(f"left out: {data}, as R's package {package} is absent")
                continue
            r.check_returncode()
            design = str(PUBLISHED / f"{study}.toml")
            documents = []
            for table in (f"{folder}/table.csv", str(PUBLISHED / f"{study}.csv")):
                run = subprocess.run([osteomill, "study", table, "--design", design, "--format", "json"],
                                     capture_output=True, text=True, check=True)
                documents.append(json.loads(run.stdout))
        for line in r.stdout.splitlines():
            name, term, what, value = line.rsplit("|", 3)
            for document in documents:
                ours = found(document, name, term, what)
                compared += 1
                if not math.isclose(ours, float(value), rel_tol=TOLERANCE.get(what, USUAL)):
                    misses += 1
                    print(f"{study}: {name}, {term}, {what}: {ours} here, {value} in R")
    print(f"{compared} numbers compared with R, {misses} differ")
    return 1 if misses else 0


if __name__ == "__main__":
    sys.exit(main())
