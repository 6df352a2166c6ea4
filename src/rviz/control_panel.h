#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/subscriber.h>
#include <rviz/panel.h>

#include <QElapsedTimer>
#include <QTimer>
#include <string>

#include "call_queue.h"

class QBoxLayout;
class QComboBox;
class QLabel;
class QPushButton;
class QSpinBox;

namespace clothsim_rviz {

class LiveControls;

/// Controls a clothsim node: pause, step, reset, scene, live values, and its status.
class ControlPanel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit ControlPanel(QWidget* parent = nullptr);
  ~ControlPanel() override;

  void load(const rviz::Config&) override;
  void save(rviz::Config) const override;

 private:
  void add_node(QBoxLayout&);
  void add_running(QBoxLayout&);
  void add_scenes(QBoxLayout&);
  void add_diagnostics(QBoxLayout&);

  /// Switches to the node that is named in node_box_.
  void set_node();
  /// Called for another scene of the node: shows it, and drops reports on the last one.
  void follow_scenes();
  void show_scene();
  void list_nodes();
  void pause_or_run();
  void step();
  /// Calls a service of the node, such as "/reset".
  void trigger(const std::string& name);
  void load_scene();
  void choose_file();
  void hear(const diagnostic_msgs::DiagnosticArray&);
  void show_status(const diagnostic_msgs::DiagnosticStatus&);
  void watch_silence();
  void show_paused(bool paused);
  /// Shows the result of a call; empty: none.
  void report(const std::string&);

  QComboBox* node_box_;
  QWidget* controls_;  // all widgets that act on the node
  QPushButton* pause_button_;
  QSpinBox* frames_box_;
  QComboBox* scene_box_;
  QLabel* factor_;
  QLabel* health_;
  QLabel* details_;
  QLabel* report_;
  std::string node_;  // full name
  bool paused_ = false;
  ros::Subscriber diagnostics_;
  ros::Subscriber changes_;
  QElapsedTimer heard_;  // since the node's last diagnostics
  QTimer silence_timer_;
  CallQueue calls_;
  LiveControls* live_;  // uses calls_, so it is deleted by hand: children are deleted last
};

}  // namespace clothsim_rviz
