#include "control_panel.h"

#include <clothsim/Change.h>
#include <clothsim/ClothState.h>
#include <clothsim/LoadScene.h>
#include <clothsim/Step.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <QComboBox>
#include <QFileDialog>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QSpinBox>
#include <QVBoxLayout>
#include <algorithm>
#include <filesystem>
#include <pluginlib/class_list_macros.hpp>
#include <vector>

#include "clothsim/model/package.h"
#include "live_controls.h"
#include "scene_files.h"

namespace clothsim_rviz {
namespace {

constexpr int max_frames = 1000000;  // of ~step
constexpr int check_silence_ms = 1000;
constexpr int silence_ms = 5000;  // after which a node that reports once a second counts as silent
constexpr std::uint32_t diagnostics_queue = 10;
constexpr std::uint32_t queue_of_changes = 1000;  // moving tf frames are changes, too

const char* color_of(unsigned char level) {
  using diagnostic_msgs::DiagnosticStatus;
  if (level == DiagnosticStatus::OK) return "#2e7d32";
  return level == DiagnosticStatus::WARN ? "#c77700" : "#c62828";
}

std::string value_of(const diagnostic_msgs::DiagnosticStatus& status, const std::string& key) {
  const auto found = std::find_if(status.values.begin(), status.values.end(),
                                  [&](const auto& item) { return item.key == key; });
  return found == status.values.end() ? "-" : found->value;
}

QString to_text(const std::string& text) { return QString::fromStdString(text); }

QLabel* wrapped_label() {
  auto* label = new QLabel;
  label->setWordWrap(true);
  label->setTextFormat(Qt::PlainText);
  return label;
}

}  // namespace

ControlPanel::ControlPanel(QWidget* parent) : rviz::Panel(parent) {
  auto* layout = new QVBoxLayout(this);
  add_node(*layout);
  controls_ = new QWidget;
  layout->addWidget(controls_);
  auto* controls = new QVBoxLayout(controls_);
  controls->setContentsMargins(0, 0, 0, 0);
  add_running(*controls);
  add_scenes(*controls);
  live_ = new LiveControls(calls_, [this](const std::string& text) { report(text); });
  controls->addWidget(live_);
  auto* values_button = new QPushButton("Values of the scene");
  values_button->setToolTip("Takes live values back to those of the scene; the cloth stays");
  controls->addWidget(values_button);
  connect(values_button, &QPushButton::clicked, this, [this] { trigger("/reset_values"); });
  add_diagnostics(*layout);
  layout->addStretch(1);
  diagnostics_ = ros::NodeHandle().subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", diagnostics_queue,
      [this](const diagnostic_msgs::DiagnosticArray::ConstPtr& array) { hear(*array); });
  connect(&silence_timer_, &QTimer::timeout, this, [this] { watch_silence(); });
  silence_timer_.start(check_silence_ms);
  set_node();
}

ControlPanel::~ControlPanel() { delete live_; }

void ControlPanel::add_node(QBoxLayout& layout) {
  node_box_ = new QComboBox;
  node_box_->setEditable(true);
  node_box_->setCurrentText("clothsim");
  node_box_->setToolTip("The clothsim node");
  auto* row = new QHBoxLayout;
  auto* refresh = new QPushButton("Find");
  row->addWidget(new QLabel("node"));
  row->addWidget(node_box_, 1);
  row->addWidget(refresh);
  layout.addLayout(row);
  connect(refresh, &QPushButton::clicked, this, [this] { list_nodes(); });
  connect(node_box_, QOverload<int>::of(&QComboBox::activated), this, [this] { set_node(); });
}

void ControlPanel::add_running(QBoxLayout& layout) {
  pause_button_ = new QPushButton("Pause");
  auto* step_button = new QPushButton("Step");
  frames_box_ = new QSpinBox;
  frames_box_->setRange(1, max_frames);
  frames_box_->setToolTip("Frames of a step");
  auto* reset_button = new QPushButton("Reset");
  auto* row = new QHBoxLayout;
  for (QWidget* widget :
       std::initializer_list<QWidget*>{pause_button_, step_button, frames_box_, reset_button}) {
    row->addWidget(widget);
  }
  layout.addLayout(row);
  connect(pause_button_, &QPushButton::clicked, this, [this] { pause_or_run(); });
  connect(step_button, &QPushButton::clicked, this, [this] { step(); });
  connect(reset_button, &QPushButton::clicked, this, [this] { trigger("/reset"); });
}

void ControlPanel::add_scenes(QBoxLayout& layout) {
  scene_box_ = new QComboBox;
  std::vector<std::filesystem::path> scenes;
  std::error_code ignored;
  for (const auto& file :
       std::filesystem::directory_iterator(clothsim::package_folder("config/scenes"), ignored)) {
    if (file.path().extension() == ".yaml") scenes.push_back(file.path());
  }
  std::sort(scenes.begin(), scenes.end());
  for (const auto& path : scenes) scene_box_->addItem(to_text(path.stem()), to_text(path));
  scene_box_->setPlaceholderText("a file of your own");
  auto* load_button = new QPushButton("Load");
  auto* file_button = new QPushButton("File...");
  auto* row = new QHBoxLayout;
  row->addWidget(new QLabel("scene"));
  row->addWidget(scene_box_, 1);
  row->addWidget(load_button);
  row->addWidget(file_button);
  layout.addLayout(row);
  connect(load_button, &QPushButton::clicked, this, [this] { load_scene(); });
  connect(file_button, &QPushButton::clicked, this, [this] { choose_file(); });
}

void ControlPanel::add_diagnostics(QBoxLayout& layout) {
  factor_ = new QLabel;
  QFont large = factor_->font();
  large.setPointSize(2 * large.pointSize());
  factor_->setFont(large);
  factor_->setToolTip("Simulated seconds per second");
  health_ = wrapped_label();
  details_ = wrapped_label();
  report_ = wrapped_label();
  for (QLabel* label : {factor_, health_, details_, report_}) layout.addWidget(label);
}

void ControlPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString node;
  if (!config.mapGetString("Node", &node)) return;
  node_box_->setCurrentText(node);
  set_node();
}

void ControlPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Node", node_box_->currentText());
}

void ControlPanel::set_node() {
  const std::string name = node_box_->currentText().toStdString();
  std::string mistake;
  const bool valid = !name.empty() && ros::names::validate(name, mistake);
  controls_->setEnabled(valid);
  if (!valid) {
    report(name.empty() ? "the node has no name" : mistake);
    return;
  }
  node_ = ros::names::resolve(name);
  heard_.invalidate();
  report("");
  watch_silence();
  live_->set_node(node_);
  follow_scenes();
  show_scene();
  Q_EMIT configChanged();
}

void ControlPanel::follow_scenes() {
  changes_ = ros::NodeHandle().subscribe<clothsim::Change>(
      node_ + "/changes", queue_of_changes, [this](const clothsim::Change::ConstPtr& change) {
        if (change->what != "load_scene") return;
        report("");
        show_scene();
      });
}

void ControlPanel::show_scene() {
  std::vector<std::string> files;
  for (int i = 0; i < scene_box_->count(); ++i) {
    files.push_back(scene_box_->itemData(i).toString().toStdString());
  }
  calls_.post([this, node = node_, files]() -> CallQueue::Answer {
    XmlRpc::XmlRpcValue scene;
    const bool has_one = ros::param::get(node + "/scene", scene);
    const std::string file = has_one ? file_of(scene, files) : "";
    return [this, file] {
      scene_box_->setCurrentIndex(file.empty() ? -1 : scene_box_->findData(to_text(file)));
    };
  });
}

void ControlPanel::list_nodes() {
  calls_.post([this]() -> CallQueue::Answer {
    ros::master::V_TopicInfo topics;
    ros::master::getTopics(topics);
    QStringList nodes;
    const std::string ending = "/state";
    for (const auto& topic : topics) {
      if (topic.datatype != ros::message_traits::datatype<clothsim::ClothState>()) continue;
      if (topic.name.size() <= ending.size()) continue;
      nodes << to_text(topic.name.substr(0, topic.name.size() - ending.size()));
    }
    nodes.sort();
    return [this, nodes] {
      const QString present = node_box_->currentText();
      node_box_->clear();
      node_box_->addItems(nodes);
      node_box_->setCurrentText(present);
      report(nodes.empty() ? "there is no clothsim node" : "");
      if (!nodes.empty()) node_box_->showPopup();
    };
  });
}

void ControlPanel::pause_or_run() {
  calls_.post([this, node = node_, pause = !paused_]() -> CallQueue::Answer {
    std_srvs::SetBool service;
    service.request.data = pause;
    const std::string refusal = refusal_of(node + "/pause", service);
    return [this, refusal, pause] {
      report(refusal);
      if (refusal.empty()) show_paused(pause);
    };
  });
}

void ControlPanel::step() {
  const auto frames = static_cast<std::uint32_t>(frames_box_->value());
  calls_.post([this, node = node_, frames]() -> CallQueue::Answer {
    clothsim::Step service;
    service.request.frames = frames;
    const std::string refusal = refusal_of(node + "/step", service);
    return [this, refusal] { report(refusal); };
  });
}

void ControlPanel::trigger(const std::string& name) {
  calls_.post([this, service_name = node_ + name]() -> CallQueue::Answer {
    std_srvs::Trigger service;
    const std::string refusal = refusal_of(service_name, service);
    return
        [this, answer = refusal.empty() ? service.response.message : refusal] { report(answer); };
  });
}

void ControlPanel::load_scene() {
  if (scene_box_->currentIndex() < 0) {
    report("choose a scene first");
    return;
  }
  const std::string file = scene_box_->currentData().toString().toStdString();
  report("loading " + file);
  calls_.post([this, node = node_, file]() -> CallQueue::Answer {
    clothsim::LoadScene service;
    service.request.file = file;
    const std::string refusal = refusal_of(node + "/load_scene", service);
    return [this, refusal] { report(refusal); };
  });
}

void ControlPanel::choose_file() {
  const QString file = QFileDialog::getOpenFileName(this, "Scene", "", "Scenes (*.yaml)");
  if (file.isEmpty()) return;
  scene_box_->addItem(QFileInfo(file).completeBaseName(), file);
  scene_box_->setCurrentIndex(scene_box_->count() - 1);
  load_scene();
}

void ControlPanel::hear(const diagnostic_msgs::DiagnosticArray& array) {
  const std::string name = node_.substr(1) + ": simulation";
  for (const auto& status : array.status) {
    if (status.name == name) show_status(status);
  }
}

void ControlPanel::show_status(const diagnostic_msgs::DiagnosticStatus& status) {
  if (!heard_.isValid()) show_scene();  // a new node
  heard_.start();
  show_paused(value_of(status, "paused") == "True");
  const double factor = to_text(value_of(status, "real-time factor")).toDouble();
  factor_->setText(paused_ ? QString("paused") : "× " + QString::number(factor, 'f', 2));
  health_->setText(to_text(status.message));
  health_->setStyleSheet(QString("color: ") + color_of(status.level));
  details_->setText(to_text(value_of(status, "method") + ", " + value_of(status, "substeps") +
                            " substeps, " + value_of(status, "contacts") + " contacts, stretch " +
                            value_of(status, "worst stretch [%]") + " %"));
  QString all;
  for (const auto& item : status.values) all += to_text(item.key + ": " + item.value + "\n");
  details_->setToolTip(all);
}

void ControlPanel::watch_silence() {
  if (heard_.isValid() && heard_.elapsed() < silence_ms) return;
  heard_.invalidate();
  factor_->setText("-");
  health_->setStyleSheet(QString("color: ") + color_of(diagnostic_msgs::DiagnosticStatus::WARN));
  health_->setText(to_text("no diagnostics of " + node_));
  details_->clear();
}

void ControlPanel::show_paused(bool paused) {
  paused_ = paused;
  pause_button_->setText(paused ? "Run" : "Pause");
}

void ControlPanel::report(const std::string& text) { report_->setText(to_text(text)); }

}  // namespace clothsim_rviz

PLUGINLIB_EXPORT_CLASS(clothsim_rviz::ControlPanel, rviz::Panel)
