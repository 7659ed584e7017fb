CREATE TEMP VIEW unanswered AS
SELECT d.model, d.request, d.occurrence, d.shown, min(d.id) AS first,
    EXISTS (SELECT 1 FROM faults f WHERE f.request = d.request AND f.model = d.model AND f.trial = d.occurrence) AS faulty
FROM draws d LEFT JOIN answers a ON a.request = d.request AND a.model = d.model AND a.trial = d.occurrence
WHERE a.request IS NULL GROUP BY d.model, d.request, d.occurrence;
CREATE TEMP VIEW replies AS
SELECT d.id, d.model, d.setting, d.context, d.people, d.trial, d.shown, d.request, d.occurrence,
    CASE WHEN a.attempt IS NOT NULL THEN 'answer' WHEN f.attempt IS NOT NULL THEN 'fault' ELSE 'open' END AS state,
    coalesce(a.status, f.status, 0) AS status, coalesce(a.content_type, f.content_type, '') AS content_type,
    coalesce(a.body, f.body, x'') AS body, coalesce(a.input_tokens, f.input_tokens, 0) AS input_tokens,
    coalesce(a.output_tokens, f.output_tokens, 0) AS output_tokens, coalesce(a.cost, f.cost, 0) AS cost
FROM draws d LEFT JOIN answers a ON a.request = d.request AND a.model = d.model AND a.trial = d.occurrence
LEFT JOIN faults f ON f.attempt =
    (SELECT max(attempt) FROM faults WHERE request = d.request AND model = d.model AND trial = d.occurrence);
CREATE TEMP VIEW unknown_fate AS
SELECT id, request, model, trial, started, coalesce(result, 'interrupted') AS result, tokens, cost
FROM attempts WHERE result IS NULL OR result LIKE 'lost:%';
CREATE TEMP VIEW charged AS
SELECT model, input_tokens, output_tokens, cost FROM answers UNION ALL SELECT model, input_tokens, output_tokens, cost FROM faults;
CREATE TEMP VIEW spending AS
SELECT model, input_tokens + output_tokens AS tokens, cost, 0 AS lost FROM charged
UNION ALL SELECT model, tokens, cost, 1 FROM unknown_fate;
CREATE TEMP VIEW ends AS
SELECT model, substr(said, 1, instr(said || ';', ';') - 1) AS result
FROM (SELECT model, coalesce(result, 'interrupted') AS said FROM attempts);
CREATE TEMP VIEW repeats AS
SELECT model, json_extract(reply, '$.id') AS id
FROM (SELECT model, request, CAST(body AS TEXT) AS reply FROM answers WHERE status = 200) WHERE json_valid(reply)
GROUP BY model, request, id HAVING count(*) > 1 AND length(id) >= 16;
