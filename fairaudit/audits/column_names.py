"""What names of columns and labels say: patterns for decisions, attributes of people, contexts and numbers, in some languages."""

from __future__ import annotations

import re

__all__ = ["named", "says"]

COUNT = (
    r"n|freq(s|uency|uencies)?|counts?|num(ber)?|total|cases|size|anzahl|häufigkeit|fälle|effectifs?|nombre|fr[eé]quence|cantidad|"
    r"frecuencia|conteo|conteggio|frequenza|quantidade|frequ[eê]ncia|contagem|aantal|liczba|liczebność"
)
SURVEY_WEIGHT = (
    r"(?!f(req|requency)?[_ .-]?w)(.*[_ .-])?(p?wgtp\d*|(fnl|final|per|hh|asec|earn|_?llcp|d|p|a|an|psp|pspw)?(wt|wgt|wght|wghts|weights?)|"
    r"wt(fin|int|mec|ss|s)[a-z0-9]*|expansion[_ .-]?factor|p?hrf|.*gewicht(e|ung)?|hochrechnung.*|poids|pond[eé]r.*|peso|waga|"
    r"fexp|fac(tor)?[_ .-]?(de[_ .-]?)?exp.*|fator[_ .-]?(de[_ .-]?)?exp.*)([_ .-]?\d+)?"
)
PROBABILITY = r"p|pr|prob(ability|abilities)?|share|rate"
WEIGHT = r"w|weights?|mass|population|prior"
RUNNING = r"(row_?)?(names?|num|number|index)|column 1|unnamed.*|(.*[_ .-])?(id|ids|uuid|key)"
IDENTIFIER = r"(row_?)?(names?|num|number|index)|column 1|x|unnamed.*|(.*[_ .-])?(id|ids|uuid|guid|key|no|nr)|case_?number|.*identifier"
UNIT = (
    r"(.*[_ .-])?(participant|subject|respondent|person|applicant|candidate|defendant|patient|user|employee|worker|session|run)"
    r"([_ .-]?(id|no|nr|number|code|key))?"
)
RACE = (
    r".*(race|ethni|colou?r|afam|black|(^|[_ .])white|minority|hispan|latin[oax]|asian|nationalit|citizen|origin|caste|foreign|immigrant|"
    r"herkunft|staatsangeh|ausländ|etni|nacionalidad).*"
)
SEX = r"(.*[_ .])?(sex|gender|geschlecht|sexe|sexo|genre|g[eé]nero)([_ .].*)?|(is[_ .]?)?(female|male|woman|man|women|men)"
SEXES = "men|women|man|woman|males?|females?|boys?|girls?|m|f|w|hommes?|femmes?|m[aä]nner|frauen|hombres?|mujeres?"
ORIGINS = (
    r"(african|asian|european|native)?[ _-]?(americans?)|blacks?|whites?|hispanics?|latin[oax]s?|asians?|african|caucasians?|minority|"
    r"minorities|majority|foreign(ers?)?|natives?|immigrants?|germans?|turks?|others?"
)
AGES = "young|old|older|younger|child(ren)?|adults?"
AGE = r"(.*[_ .])?(age|alter|âge|edad)([_ .]?(group|cat|category|band|range|class|bracket|years|gruppe))?"
OTHER = (
    r".*(religion|disab|orientation|marital|married|pregnan|veteran|language|group|placebo|treatment_arm).*|a|s|names?|firstname|first_name"
)
CONTEXT = (
    r".*(dept|department|major|program|faculty|school|job|position|occupation|profession|role|class|model|document|scenario|prompt|question|"
    r"categor|stratum|branch|site|court|district|degree|jd|wanted|vacancy|task|context|resume|crime|charge|city|region|county|"
    r"industry|sector|discipline|rank|division|precinct|abteilung|fach|studiengang|fakult|filière|departamento|beruf|stelle).*|.*place|x"
)
GOOD = (
    r".*(decision|outcome|hired?|admi(t|ssion)|accept|approv|grant|select|cho(sen|ice)|recommend|offer|promot|(?<![a-z])call(ed)?(?![a-z])|call_?back|interview|"
    r"released?|surviv|answer|respon[sd]|winner|(?<![a-z])first(?![a-z]|_?name)|eligib|award|funded|repaid|paid|pass(ed)?(?![a-z])|graduat|"
    r"zugelassen|zulassung|eingestellt|angenommen|bewillig|genehmig|zusage|embauch|retenu|contratad|aprobad|admitid).*|u"
)
BAD = (
    r".*(den(y|ied|ial)|reject|refus|declin|default|recid|re_?offend|arrest|convict|guilt|sentenc|verdict|penalty|prison|jail|death|"
    r"(?<![a-z])(dead|die[ds]?|search|searche[ds]|bad|fine[ds]?|risk)(?![a-z])|"
    r"citation|fraud|churn|suspend|expel|expuls|fired|layoff|complain|delinquen|charged_?off|attrition|turnover|drop_?out|relapse|"
    r"abgelehnt|absage|rechaz|verhaft|kontroll).*"
)
NEUTRAL = r".*(result|label|predict|status|target|score_text|judg|employment|ergebnis|entscheidung|bescheid).*|(.*[_ .-])?class|y"
YES = (
    r"(yes|y|true|t|1|1\.0|.*(admit|accept|hire|approv|grant|select|chosen|recommend|releas|pass|surviv|promot|offer|success|good|positive|paid|invit|agree).*|"
    r"first|called?|callback|>.*|alive|lived|ja|oui|si|sí|sim|.*(zugelassen|eingestellt|angenommen|bewilligt|genehmigt|zusage|admis|embauch|aprobad).*)"
)
HARM = (
    r"(yes|y|true|t|1|1\.0|ja|oui|si|sí|sim|.*(den|reject|refus|declin|default|recid|arrest|convict|guilt|death|dead|died|bad|high|search|fraud|charged|fired|"
    r"abgelehnt|absage).*)"
)
NOT = (
    r"(no|not|non|nein|nicht)([ _.-].*)?|(non|not|no|un|in|dis)(admit|accept|hire|approv|grant|select|chos|recommend|releas|pass|surviv|"
    r"promot|success|agree|paid|eligib|qualif|convict|arrest|call|fund|death|invit).*|.*\b(not|nicht|never)\b.*"
)
SCORE = (
    r"(.*[_ .-])?(scores?|ratings?|salary|wages?|earnings|bonus|total|gehalt|lohn|punkte|salaire|sueldo|"
    r"sentence|bail|bond|premium|fines?|penalty|apr)"
    r"([_ .-].*)?"
)
RATED = r"(.*[_ .-])?(scores?|ratings?|total|points|marks?|punkte)([_ .-].*)?"
AMOUNT = (
    r"(.*[_ .-])?(income|grades?|points|marks?|pay|amount|limit|price|note|years|months|days|fees?|interest|wait|delay|severity)([_ .-].*)?"
)
COSTS = r".*(sentence|years|months|days|bail|bond|premium|fee|fine|penalty|interest|apr|wait|delay|severity|risk|recid|decile).*"
HISTORY = (
    r".*(since|service|exper|prior|previous|seniority|tenure|birth|born|educ|school|college|juv|employ(?!ed$)).*|"
    r"(.*[_ .-])?(age|yrs)([_ .-].*)?"
)
WINNER = r".*(winner|won|chosen|choice|choose|chose|pick|selected|ranked|ranking|ranks|best|hired|preferred|answer).*"
SLOT = r"(.+?)([_ .-]?\d+|[_ .-][a-h])"


def named(name: str, pattern: str) -> bool:
    """Whether the name of a column is of a kind.

    Examples
    --------
    >>> named(" Hired ", GOOD), named("Dept", GOOD)
    (True, False)
    """
    return re.fullmatch(pattern, name.strip().lower()) is not None


def says(label: str, pattern: str) -> bool:
    """Whether a label says it, and not the contrary.

    Examples
    --------
    >>> says("Admitted", YES), says("not admitted", YES)
    (True, False)
    """
    return named(label, pattern) and not named(label, NOT)
