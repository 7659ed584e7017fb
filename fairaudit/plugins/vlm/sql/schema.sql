CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE draws (
    id INTEGER PRIMARY KEY, model TEXT NOT NULL, setting INTEGER NOT NULL, context TEXT NOT NULL, people TEXT NOT NULL,
    trial INTEGER NOT NULL, shown TEXT NOT NULL, request TEXT NOT NULL, occurrence INTEGER NOT NULL,
    UNIQUE (model, setting, context, people, trial)
);
CREATE INDEX draws_by_request ON draws (request, model, occurrence);
CREATE TABLE requests (hash TEXT PRIMARY KEY, body TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE attempts (
    id INTEGER PRIMARY KEY, request TEXT NOT NULL, model TEXT NOT NULL, trial INTEGER NOT NULL, started REAL NOT NULL, ended REAL,
    result TEXT, tokens INTEGER NOT NULL, cost REAL NOT NULL
);
CREATE TABLE answers (
    request TEXT NOT NULL, model TEXT NOT NULL, trial INTEGER NOT NULL, attempt INTEGER NOT NULL, status INTEGER NOT NULL,
    content_type TEXT NOT NULL, body BLOB NOT NULL, input_tokens INTEGER NOT NULL, output_tokens INTEGER NOT NULL, cost REAL NOT NULL,
    received REAL NOT NULL,
    PRIMARY KEY (request, model, trial)
) WITHOUT ROWID;
CREATE TABLE faults (
    attempt INTEGER PRIMARY KEY, request TEXT NOT NULL, model TEXT NOT NULL, trial INTEGER NOT NULL, status INTEGER NOT NULL,
    content_type TEXT NOT NULL, body BLOB NOT NULL, input_tokens INTEGER NOT NULL, output_tokens INTEGER NOT NULL, cost REAL NOT NULL,
    received REAL NOT NULL
);
CREATE INDEX faults_by_request ON faults (request, model, trial);
